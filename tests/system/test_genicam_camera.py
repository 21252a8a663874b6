"""GenICam through Aravis, against its own fake camera: skipped where the library is not."""

from __future__ import annotations

import fcntl
import shutil
import subprocess
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from rigctl.cameras.genicam import Genicam, library
from rigctl.cameras.live import LiveCapture
from rigctl.config import GenicamCamera
from rigctl.errors import (
    ConfigurationError,
    DeviceAbsentError,
    DeviceAnswerError,
    DeviceError,
    FramesError,
)
from tests.system.real_rig import until

RATE_HZ = 20.0

try:
    with warnings.catch_warnings():
        # The library's bindings warn of what they will change themselves.
        warnings.simplefilter("ignore")
        ARAVIS = library()
except ConfigurationError:
    ARAVIS = None

needs_aravis = pytest.mark.skipif(
    ARAVIS is None, reason="needs gir1.2-aravis-0.8 and the extra genicam"
)
GIGE = shutil.which("arv-fake-gv-camera-0.8")
"""A camera of another process, that speaks GigE Vision over the network of this host."""
needs_gige = pytest.mark.skipif(
    ARAVIS is None or GIGE is None,
    reason="needs aravis-tools, gir1.2-aravis-0.8 and the extra genicam",
)
pytestmark = pytest.mark.filterwarnings("ignore")


def section(**changes: object) -> GenicamCamera:
    fields = {
        "kind": "genicam", "camera_id": "Fake_1", "frame_rate_hz": RATE_HZ,
        "rows": 192, "columns": 240, "start_timeout_s": 20.0, "collect_timeout_s": 20.0,
        "frames_before_mark": 5, "frames_after_mark": 10,
    }  # fmt: skip
    return GenicamCamera.model_validate(fields | changes)


@needs_aravis
def test_frames_about_a_mark_come_with_numbers_and_times_of_the_camera() -> None:
    capture = LiveCapture(section(), Genicam(section(), ARAVIS))
    try:
        capture.check()
        confirmed = capture.start()
        assert "frames at" in confirmed.evidence
        capture.mark()
        frames = capture.collect()
    finally:
        capture.close()
    wanted = set(range(int(frames.sequence[0]), int(frames.sequence[0]) + 15))
    assert set(frames.sequence.tolist()) | set(frames.lost) == wanted
    assert frames.pixels.shape[1:] == (192, 240)
    steps = np.diff(frames.times_s) / np.diff(frames.sequence)
    assert np.median(steps) == pytest.approx(1 / RATE_HZ, rel=0.1)


@pytest.fixture
def alone() -> Iterator[None]:
    """The network's camera is nobody else's meanwhile, in whichever process tests run besides."""
    with (Path(tempfile.gettempdir()) / "rigctl-gige.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


@contextmanager
def gige_camera(*options: str) -> Iterator[subprocess.Popen[bytes]]:
    """The library's camera on the network of this host."""
    camera = subprocess.Popen(
        [str(GIGE), "-i", "127.0.0.1", "-s", "RIGFAKE", *options],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        yield camera
    finally:
        camera.kill()
        camera.wait()


def is_there(capture: LiveCapture) -> bool:
    try:
        capture.check()
    except DeviceError:
        return False
    return True


@needs_gige
@pytest.mark.usefixtures("alone")
@pytest.mark.parametrize("dropped", [0, 10])
def test_every_frame_of_a_gige_camera_comes_or_is_named_lost(dropped: int) -> None:
    asked = section(camera_id="Aravis-RIGFAKE", frames_after_mark=40)
    capture = LiveCapture(asked, Genicam(asked, ARAVIS))
    # Of a thousand packets; a frame has some thirty.
    with gige_camera("-r", str(dropped)):
        until(lambda: is_there(capture))
        try:
            capture.start()
            capture.mark()
            frames = capture.collect()
        finally:
            capture.close()
    numbers = [*frames.sequence.tolist(), *frames.lost]
    assert sorted(numbers) == list(range(min(numbers), min(numbers) + 45))
    assert frames.lost or not dropped


@needs_gige
@pytest.mark.usefixtures("alone")
@pytest.mark.long
def test_a_gige_camera_whose_cable_was_pulled_is_named_and_records_again_once_it_is_back() -> None:
    asked = section(camera_id="Aravis-RIGFAKE", collect_timeout_s=2.0)
    capture = LiveCapture(asked, Genicam(asked, ARAVIS))
    try:
        with gige_camera():
            until(lambda: is_there(capture))
            capture.start()
        capture.mark()
        with pytest.raises(FramesError, match=r"RIGFAKE.*did not come"):
            capture.collect()
        with pytest.raises(DeviceAbsentError, match="RIGFAKE"):
            capture.check()
        with gige_camera():
            until(lambda: is_there(capture))
            capture.start()
            capture.mark()
            assert len(capture.collect().sequence) > 0
    finally:
        capture.close()


@needs_aravis
def test_a_size_that_the_camera_has_not_is_refused_by_its_numbers() -> None:
    large = section(rows=4096, columns=4096)
    source = Genicam(large, ARAVIS)
    with pytest.raises(DeviceAnswerError, match="at most 2048 by 2048"):
        source.start()
    source.close()


@pytest.mark.parametrize(
    ("blocks", "numbers", "lost"),
    [
        ([7, 8, 11], [7, 8, 11], [9, 10]),
        ([65534, 65535, 1, 3], [65534, 65535, 65536, 65538], [65537]),
        ([65535, 0, 1], [65535, 65536, 65537], []),
    ],
)
def test_numbers_are_counted_on_past_their_sixteen_bits(
    blocks: list[int], numbers: list[int], lost: list[int]
) -> None:
    source = Genicam(section(), ARAVIS)
    counted = [source._counted(block) for block in blocks]
    assert [number for number, _ in counted] == numbers
    assert [number for _, gone in counted for number in gone] == lost


@needs_aravis
def test_a_camera_that_is_not_there_is_absent_by_its_name() -> None:
    Genicam(section(), ARAVIS).check()
    with pytest.raises(DeviceAbsentError, match=r"Nobody-0.*cameras that answer: .*Fake_1"):
        Genicam(section(camera_id="Nobody-0"), ARAVIS).check()


def test_without_the_library_the_configuration_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "gi", None)
    with pytest.raises(ConfigurationError, match=r"gir1\.2-aravis-0\.8"):
        library()
