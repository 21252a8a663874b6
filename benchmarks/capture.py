"""Whether capture keeps up with a video device, and names each loss: python -m benchmarks.capture.

The device is an emulated V4L2 driver below the project's own reader: frames fall due by the clock,
each takes a queued buffer or is lost when there is none, and the driver keeps a list of what it
lost. Some frames are left out or damaged on purpose. A run is a whole recording of the rig's live
capture: streaming confirmed, a mark, the frames after it collected and checked. Prints a table and
writes out/capture.json; ends 1 if a frame was lost that should not, or a loss was not named.
"""

from __future__ import annotations

import argparse
import errno
import json
import os
import random
import struct
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from rigctl.cameras.live import LiveCapture
from rigctl.cameras.v4l2 import VideoDevice
from rigctl.config import PixelFormatName, V4l2Camera

OUT = Path("out/capture.json")
QUERYCAP, S_FMT, REQBUFS, QUERYBUF = 0x80685600, 0xC0D05605, 0xC0145608, 0xC0585609
QBUF, DQBUF = 0xC058560F, 0xC0585611
"""Requests of linux/videodev2.h on 64-bit Linux."""
CAPTURE_AND_STREAM, MONOTONIC, DAMAGED = 0x0400_0001, 0x2000, 0x40
PAGE = 4096
LOOKS = 61
"""Different pictures, one after another: two that are alike would pass for a frozen camera."""
BEFORE_FIRST = 100
"""Frames before the first one that is left out: the recording is confirmed on whole ones."""


@dataclass(frozen=True)
class Case:
    """A format, a rate in frames/s, and how long it is recorded, s."""

    rows: int
    columns: int
    pixel_format: PixelFormatName
    rate_hz: float
    seconds: float


CASES = (
    Case(192, 240, "GREY", 60.0, 10.0),
    Case(192, 240, "GREY", 250.0, 10.0),
    Case(480, 640, "YUYV", 60.0, 10.0),
    Case(480, 640, "YUYV", 250.0, 4.0),
)


@dataclass(frozen=True)
class Result:
    """What came of a case; `unnamed` are losses of which the recording does not speak."""

    case: Case
    frames: int
    injected: int
    lost_besides: int
    unnamed: int
    falsely_named: int
    load: float


class Driver:
    """A driver whose frames fall due by the clock, with a list of all that it lost.

    Parameters
    ----------
    case
        Format and rate.
    left_out, damaged
        Sequence numbers that never come, and that come with the error flag.
    """

    def __init__(self, case: Case, left_out: frozenset[int], damaged: frozenset[int]) -> None:
        self._case, self._left_out, self._damaged = case, left_out, damaged
        self._line = case.columns * (2 if case.pixel_format == "YUYV" else 1)
        size = self._line * case.rows
        random_bytes = np.random.default_rng(1).integers(0, 256, (LOOKS, size), dtype=np.uint8)
        self._looks = [each.tobytes() for each in random_bytes]
        self._size, self._pages = size, -(-size // PAGE) * PAGE
        self._memory: list[bytearray] = []
        self._queued: list[int] = []
        self._filled: list[tuple[int, int]] = []
        self._began, self._next = time.monotonic(), 0
        self.no_buffer: set[int] = set()

    def open(self, path: str) -> int:
        """Open the only device."""
        return len(path)

    def close(self, descriptor: int) -> None:
        """Close it."""

    def map(self, descriptor: int, length: int, offset: int) -> Mapped:
        """Map a buffer."""
        return Mapped(self._memory[offset // self._pages])

    def readable(self, descriptor: int, timeout_s: float) -> bool:
        """Wait until a frame has fallen due and found a buffer."""
        ends = time.monotonic() + timeout_s
        while not self._filled and time.monotonic() < ends:
            self._advance()
            if not self._filled:
                due = self._began + self._next / self._case.rate_hz
                time.sleep(max(0.0, min(due, ends) - time.monotonic()))
                self._advance()
        return bool(self._filled)

    def ioctl(self, descriptor: int, request: int, argument: bytearray) -> None:
        """Answer as a driver that grants what it is asked for."""
        if request == QUERYCAP:
            struct.pack_into("I", argument, 84, CAPTURE_AND_STREAM)
        elif request == S_FMT:
            struct.pack_into("II", argument, 24, self._line, self._size)
        elif request == REQBUFS:
            (count,) = struct.unpack_from("I", argument, 0)
            self._memory = [bytearray(self._pages) for _ in range(count)]
        elif request == QUERYBUF:
            (index,) = struct.unpack_from("I", argument, 0)
            struct.pack_into("I", argument, 64, index * self._pages)
            struct.pack_into("I", argument, 72, self._size)
        elif request == QBUF:
            self._advance()
            self._queued.append(struct.unpack_from("I", argument, 0)[0])
        elif request == DQBUF:
            self._advance()
            if not self._filled:
                raise OSError(errno.EAGAIN, os.strerror(errno.EAGAIN))
            self._hand_over(argument, *self._filled.pop(0))

    def _advance(self) -> None:
        due = int((time.monotonic() - self._began) * self._case.rate_hz)
        while self._next <= due:
            number, self._next = self._next, self._next + 1
            if number in self._left_out:
                continue
            if not self._queued:
                self.no_buffer.add(number)
                continue
            index = self._queued.pop(0)
            self._memory[index][: self._size] = self._looks[number % len(self._looks)]
            self._filled.append((number, index))

    def _hand_over(self, argument: bytearray, number: int, index: int) -> None:
        flags = MONOTONIC | (DAMAGED if number in self._damaged else 0)
        micros = round((self._began + number / self._case.rate_hz) * 1e6)
        struct.pack_into("I", argument, 0, index)
        struct.pack_into("II", argument, 8, self._size, flags)
        struct.pack_into("qq", argument, 24, *divmod(micros, 1_000_000))
        struct.pack_into("I", argument, 56, number)


@dataclass
class Mapped:
    """A buffer of the driver."""

    data: bytearray

    def __getitem__(self, place: slice) -> bytes:
        """Return a copy."""
        return bytes(self.data[place])

    def close(self) -> None:
        """Unmap it."""


def record(case: Case, losses: int) -> Result:
    """Record one shot with so many frames left out, and as many damaged."""
    count = int(case.rate_hz * case.seconds)
    drawn = random.Random(1).sample(range(BEFORE_FIRST, count), 2 * losses)
    left_out, damaged = frozenset(drawn[:losses]), frozenset(drawn[losses:])
    driver = Driver(case, left_out, damaged)
    size = {"rows": case.rows, "columns": case.columns, "pixel_format": case.pixel_format}
    camera = V4l2Camera.model_validate(
        {
            "kind": "v4l2",
            "device": "/dev/video0",
            **size,
            "frame_rate_hz": case.rate_hz,
            "start_timeout_s": 10.0,
            "collect_timeout_s": case.seconds + 10.0,
            "frames_before_mark": 10,
            "frames_after_mark": count,
        }
    )
    device = VideoDevice(
        camera.device,
        rows=case.rows,
        columns=case.columns,
        pixel_format=case.pixel_format,
        kernel=driver,
    )
    capture = LiveCapture(camera, device)
    try:
        capture.start()
        capture.mark()
        frames = capture.collect()
    finally:
        capture.close()
    window = range(int(frames.sequence[0]), int(frames.sequence[-1]) + 1)
    injected = {number for number in left_out | damaged if number in window}
    besides = {number for number in driver.no_buffer if number in window}
    lost = injected | besides
    named = set(frames.lost)
    return Result(
        case,
        len(frames.sequence),
        len(injected),
        len(besides),
        len(lost - named),
        len({number for number in named if number in window} - lost),
        round(os.getloadavg()[0], 1),
    )


def main() -> int:
    """Run every case, print, write, and say whether all is as it should be."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.capture", description=__doc__)
    parser.add_argument("--losses", type=int, default=20, help="left out, and damaged, a run")
    given = parser.parse_args()
    results = [record(case, given.losses) for case in CASES]
    print(f"cores: {os.cpu_count()}")
    print("format              frames/s  frames  injected  lost besides  unnamed  false  load")
    for each in results:
        case = each.case
        print(
            f"{case.columns} x {case.rows} {case.pixel_format:<9} {case.rate_hz:8.0f} "
            f"{each.frames:7} {each.injected:9} {each.lost_besides:13} {each.unnamed:8} "
            f"{each.falsely_named:6} {each.load:5}"
        )
    OUT.parent.mkdir(parents=True, exist_ok=True)
    OUT.write_text(json.dumps([asdict(each) for each in results], indent=2) + "\n")
    return int(any(each.lost_besides or each.unnamed or each.falsely_named for each in results))


if __name__ == "__main__":
    raise SystemExit(main())
