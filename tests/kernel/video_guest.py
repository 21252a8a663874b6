"""Runs in the guest: the project's reader on a real video device. Prints a JSON line a story."""

from __future__ import annotations

import hashlib
import json
import subprocess
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path

import numpy as np

from rigctl.cameras.playback import Crop, ResampledVideo
from rigctl.cameras.v4l2 import VideoDevice
from rigctl.errors import DeviceAnswerError, RigError

CAPTURE, OUTPUT = "/dev/video0", "/dev/video1"
ROWS, COLUMNS, PICTURES = 192, 240, 40
WEBCAM, HDMI = 0, 1
READ_S = 20.0
TRIES = 3
"""Of a story that a halted machine spoils: vivid counts frames by the clock."""

_told: list[str] = []


def control(*words: str) -> None:
    subprocess.run(["v4l2-ctl", *words], check=True, capture_output=True)


def tell(story: str, **found: object) -> None:
    _told.append(json.dumps({"story": story, **found}))


def camera(rows: int, columns: int, name: str = "GREY", number: int = WEBCAM) -> VideoDevice:
    return VideoDevice(CAPTURE, rows=rows, columns=columns, pixel_format=name, input_number=number)  # type: ignore[arg-type]


def loop_back() -> None:
    """Known pictures out of one node and in by the other, joined inside the kernel."""
    chance = np.random.default_rng(3)
    pictures = chance.integers(0, 256, (PICTURES, ROWS, COLUMNS), dtype=np.uint8)
    path = Path(tempfile.mkdtemp()) / "pictures"
    path.write_bytes(pictures.tobytes())
    size = f"width={COLUMNS},height={ROWS},pixelformat=GREY"
    control("-d0", "-i", "1")
    control("-d0", "-v", size)
    control("-d1", "-x", size)
    # Whole multiples in both directions: what lies between would resample otherwise.
    whole = "left=0,top=0,width=720,height=576"
    control("-d1", f"--set-selection-output=target=compose,{whole}")
    control("-d0", f"--set-selection=target=crop,{whole}")
    control("-d0", "-c", "loop_video=1,osd_text_mode=2")
    sender = subprocess.Popen(
        ["v4l2-ctl", "-d1", "--stream-out-mmap", "--stream-loop", f"--stream-from={path}"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    known = {hashlib.sha256(picture.tobytes()).digest() for picture in pictures}
    with ExitStack() as ending:
        ending.callback(sender.wait)
        ending.callback(sender.terminate)
        device = ending.enter_context(closing(camera(ROWS, COLUMNS, number=HDMI)))
        device.start()
        first = device.read(READ_S)
        frames = [device.read(READ_S) for _ in range(60)]
        exact = [hashlib.sha256(frame.pixels.tobytes()).digest() in known for frame in frames]
        # Where the sender is late the kernel shows noise of its own: nothing of a picture.
        alike = [
            max(float(np.mean(frame.pixels == picture)) for picture in pictures)
            for frame, whole in zip(frames, exact, strict=True)
            if not whole
        ]
        numbers = [first.number, *(frame.number for frame in frames)]
        times = [first.time_s, *(frame.time_s for frame in frames)]
        tell(
            "loop back",
            frames=len(frames),
            exact=sum(exact),
            alike=max(alike, default=0.0),
            numbers=numbers,
            lost=[number for frame in frames for number in frame.lost],
            rises=bool(np.all(np.diff(times) > 0)),
        )
        time.sleep(0.4)
        late = [device.read(READ_S) for _ in range(20)]
        tell(
            "reader asleep",
            numbers=[frame.number for frame in late],
            before=frames[-1].number,
            lost=[number for frame in late for number in frame.lost],
        )


def formats() -> None:
    """The same test picture in each format, from the webcam input."""
    control("-d0", "-i", "0")
    control("-d0", "-c", "osd_text_mode=2,test_pattern=0")
    for name in ("GREY", "YUYV", "UYVY", "Y10", "Y12", "Y16"):
        with closing(camera(180, 320, name)) as device:
            device.start()
            pixels = device.read(READ_S).pixels
            bars = pixels[60:70].reshape(10, 8, 40)[:, :, 15:25].mean(axis=(0, 2))
            tell("format", name=name, shape=pixels.shape, bars=[float(bar) for bar in bars])


def cropped() -> None:
    """Frames of a grabber's sizes, cut and brought to a picture of the recorder."""
    control("-d0", "-c", "loop_video=0")
    for number, size, name, crop in (
        (WEBCAM, (480, 640), "YUYV", Crop(48, 80, 384, 480)),
        (HDMI, (576, 720), "GREY", Crop(0, 0, 576, 720)),
        (HDMI, (576, 720), "UYVY", Crop(96, 120, 384, 480)),
    ):
        control("-d0", "-i", str(number))
        control("-d0", "-c", "osd_text_mode=2,test_pattern=0")
        with closing(camera(*size, name, number)) as device:
            device.start()
            whole = device.read(READ_S).pixels
        with closing(ResampledVideo(camera(*size, name, number), crop, ROWS, COLUMNS)) as video:
            video.start()
            picture = video.read(READ_S).pixels
        part = whole[crop.top : crop.top + crop.rows, crop.left : crop.left + crop.columns]
        times = crop.rows // ROWS
        means = part.reshape(ROWS, times, COLUMNS, times).mean(axis=(1, 3))
        tell(
            "cropped",
            name=name,
            whole=whole.shape,
            picture=picture.shape,
            range=int(np.ptp(picture)),
            off=float(np.abs(picture - means).max()),
        )


def refused(story: str, act: Callable[[], object]) -> None:
    try:
        act()
    except RigError as error:
        tell(story, error=type(error).__name__, text=str(error))
    else:
        tell(story, error=None)


def refusals() -> None:
    """A size that the device has not, a second reader, a damaged frame, a camera pulled out."""
    refused("other size", camera(181, 333).start)
    with closing(camera(180, 320)) as device:
        device.start()
        before = device.read(READ_S).number
        other = camera(180, 320)
        refused("two readers", other.start)
        other.close()
        numbers, lost = [], []
        for _ in range(3):
            control("-d0", "-c", "inject_v4l2_buf_flag_error=1")
            for _ in range(8):
                frame = device.read(READ_S)
                numbers.append(frame.number)
                lost.extend(frame.lost)
        tell("damaged frames", before=before, numbers=numbers, lost=lost)
        control("-d0", "-c", "percentage_of_dropped_buffers=30")
        before, numbers, lost = frame.number, [], []
        for _ in range(40):
            frame = device.read(READ_S)
            numbers.append(frame.number)
            lost.extend(frame.lost)
        control("-d0", "-c", "percentage_of_dropped_buffers=0")
        tell("dropped frames", before=before, numbers=numbers, lost=lost)
        control("-d0", "-c", "disconnect=1")
        refused("pulled out", lambda: [device.read(2.0) for _ in range(20)])


def print_told() -> None:
    for line in _told:
        print("STORY", line, flush=True)  # noqa: T201
    _told.clear()


def run(story: Callable[[], None]) -> None:
    """Run a story, again where the machine was halted for so long that one number came twice."""
    for left in reversed(range(TRIES)):
        try:
            story()
        except DeviceAnswerError as error:
            _told.clear()
            if "came twice" not in str(error):
                raise
            if not left:
                tell("halted", text=str(error))
        else:
            break
    print_told()


for story in (loop_back, formats, cropped, refusals):
    run(story)
