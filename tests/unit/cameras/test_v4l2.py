"""A video device over a kernel of a few lines, which keeps its own record of the protocol."""

from __future__ import annotations

import errno
import os
import struct
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigctl.cameras.v4l2 import VideoDevice, VideoFrame
from rigctl.cameras.v4l2_structs import LinuxKernel
from rigctl.errors import (
    DeviceAbsentError,
    DeviceAnswerError,
    DeviceBusyError,
    DeviceError,
    DeviceSilentError,
    FramesError,
)

ROWS, COLUMNS, STRIDE = 4, 6, 8
QUERYCAP, S_FMT, REQBUFS, QUERYBUF = 0x80685600, 0xC0D05605, 0xC0145608, 0xC0585609
QBUF, DQBUF, STREAMON, STREAMOFF, S_INPUT = (
    0xC058560F, 0xC0585611, 0x40045612, 0x40045613, 0xC0045627,
)  # fmt: skip
MONOTONIC, ERROR = 0x2000, 0x40


@dataclass
class Fill:
    """One frame that the driver has ready."""

    sequence: int
    flags: int = MONOTONIC
    used: int = STRIDE * ROWS
    time_s: float = 1.5


@dataclass
class Driver:
    """Grants GREY with a stride wider than the image, and three buffers whatever is asked."""

    fills: list[Fill] = field(default_factory=list)
    code: bytes = b"GREY"
    rows: int = ROWS
    granted: int = 3
    capabilities: int = 0x0400_0001
    fails: dict[int, int] = field(default_factory=dict)
    now: float = 0.0
    queued: list[int] = field(default_factory=list)
    memory: list[bytearray] = field(default_factory=list)
    calls: list[int] = field(default_factory=list)
    open_now: int = 0
    mapped_now: int = 0

    def clock(self) -> float:
        return self.now

    def open(self, path: str) -> int:
        if "open" in path:
            raise OSError(errno.EACCES, "denied")
        self.open_now += 1
        return 42

    def close(self, descriptor: int) -> None:
        assert self.mapped_now == 0
        self.open_now -= 1
        self.queued.clear()

    def map(self, descriptor: int, length: int, offset: int) -> Mapped:
        self.mapped_now += 1
        assert offset % 4096 == 0
        return Mapped(self, self.memory[offset // 4096])

    def readable(self, descriptor: int, timeout_s: float) -> bool:
        assert timeout_s > 0
        self.now += 0.001 if self.fills else timeout_s
        return bool(self.fills)

    def ioctl(self, descriptor: int, request: int, argument: bytearray) -> None:
        self.calls.append(request)
        if request in self.fails:
            raise OSError(self.fails[request], os.strerror(self.fails[request]))
        if request == QUERYCAP:
            struct.pack_into("I", argument, 84, self.capabilities)
        if request == S_FMT:
            struct.pack_into("I", argument, 12, self.rows)
            argument[16:20] = self.code
            struct.pack_into("II", argument, 24, STRIDE, STRIDE * ROWS)
        if request == REQBUFS:
            struct.pack_into("I", argument, 0, self.granted)
            self.memory = [bytearray(STRIDE * ROWS) for _ in range(self.granted)]
        if request == QUERYBUF:
            (index,) = struct.unpack_from("I", argument, 0)
            struct.pack_into("I", argument, 64, index * 4096)
            struct.pack_into("I", argument, 72, STRIDE * ROWS)
        if request == QBUF:
            (index,) = struct.unpack_from("I", argument, 0)
            assert index not in self.queued, "a buffer was queued twice"
            self.queued.append(index)
        if request == DQBUF:
            self._fill(argument)

    def _fill(self, argument: bytearray) -> None:
        fill, index = self.fills.pop(0), self.queued.pop(0)
        self.memory[index][:] = image(fill.sequence)
        struct.pack_into("I", argument, 0, index)
        struct.pack_into("II", argument, 8, fill.used, fill.flags)
        seconds = int(fill.time_s)
        struct.pack_into("qq", argument, 24, seconds, round((fill.time_s - seconds) * 1e6))
        struct.pack_into("I", argument, 56, fill.sequence)


@dataclass
class Mapped:
    driver: Driver
    data: bytearray

    def __getitem__(self, place: slice) -> bytes:
        return bytes(self.data[place])

    def close(self) -> None:
        self.driver.mapped_now -= 1


def image(sequence: int) -> bytes:
    """Image bytes that depend on the number; the bytes beyond each row's end are 255."""
    row = bytes((sequence + column) % 200 for column in range(COLUMNS)) + b"\xff" * 2
    return row * ROWS


def device(driver: Driver, path: str = "/dev/video7") -> VideoDevice:
    return VideoDevice(
        path, rows=ROWS, columns=COLUMNS, input_number=1, kernel=driver, clock=driver.clock
    )


def all_frames(fills: list[Fill]) -> list[VideoFrame]:
    """Read until the driver has nothing more."""
    video = device(Driver(fills))
    video.start()
    frames = []
    try:
        while True:
            frames.append(video.read(1.0))
    except DeviceSilentError:
        return frames


def test_frames_come_with_number_and_kernel_time_and_without_the_strides_padding() -> None:
    frames = all_frames([Fill(5, time_s=1.5), Fill(6, time_s=1.501)])
    assert [frame.number for frame in frames] == [5, 6]
    assert [frame.time_s for frame in frames] == [1.5, pytest.approx(1.501)]
    assert frames[0].pixels.shape == (ROWS, COLUMNS)
    assert frames[0].pixels[2].tolist() == [5, 6, 7, 8, 9, 10]
    assert frames[1].pixels.max() < 255


def test_more_frames_than_buffers_go_round_and_none_is_overwritten_while_held() -> None:
    frames = all_frames([Fill(number) for number in range(10)])
    for frame in frames:
        np.testing.assert_array_equal(frame.pixels[0], (frame.number + np.arange(COLUMNS)) % 200)


def test_the_steps_to_a_stream_are_those_of_the_interface() -> None:
    driver = Driver()
    video = device(driver)
    video.start()
    assert driver.calls == [QUERYCAP, S_INPUT, S_FMT, REQBUFS, *[QUERYBUF, QBUF] * 3, STREAMON]
    video.start()
    assert driver.calls.count(STREAMON) == 1
    video.close()
    video.close()
    assert driver.calls[-1] == STREAMOFF
    assert (driver.open_now, driver.mapped_now) == (0, 0)


def test_frames_that_the_driver_dropped_are_named_by_the_next() -> None:
    frames = all_frames([Fill(0), Fill(1), Fill(4), Fill(5)])
    assert [frame.lost for frame in frames] == [(), (), (2, 3), ()]


def test_a_jump_before_the_second_frame_is_the_streams_beginning_and_no_loss() -> None:
    frames = all_frames([Fill(0), Fill(31), Fill(33)])
    assert [frame.lost for frame in frames] == [(), (), (32,)]


@pytest.mark.parametrize(
    "bad", [Fill(2, flags=MONOTONIC | ERROR), Fill(2, used=STRIDE * ROWS - 1), Fill(2, used=0)]
)
def test_a_damaged_or_short_frame_is_lost_and_its_buffer_goes_back(bad: Fill) -> None:
    frames = all_frames([Fill(0), Fill(1), bad, Fill(3), *map(Fill, range(4, 9))])
    assert [frame.number for frame in frames] == [0, 1, 3, 4, 5, 6, 7, 8]
    assert frames[2].lost == (2,)


def test_a_damaged_frame_before_a_time_limit_is_named_by_the_next_whole_one() -> None:
    driver = Driver([Fill(0), Fill(1), Fill(2, flags=MONOTONIC | ERROR)])
    video = device(driver)
    video.start()
    for _ in range(2):
        video.read(1.0)
    with pytest.raises(DeviceSilentError, match="1 damaged"):
        video.read(0.1)
    driver.fills.append(Fill(3))
    assert video.read(0.1).lost == (2,)


@given(st.lists(st.booleans(), min_size=1, max_size=60))
def test_every_number_is_a_frame_or_is_named_lost(kept: list[bool]) -> None:
    numbers = [0, 1] + [number for number, keep in enumerate(kept, start=2) if keep]
    frames = all_frames([Fill(number) for number in numbers])
    accounted = sorted([f.number for f in frames] + [lost for f in frames for lost in f.lost])
    assert accounted == list(range(numbers[-1] + 1))


def test_numbers_go_on_rising_past_the_counters_end() -> None:
    top = 2**32 - 1
    frames = all_frames([Fill(top - 2), Fill(top - 1), Fill(top), Fill(1), Fill(2)])
    assert all(after.number > before.number for before, after in pairwise(frames))
    assert [frame.lost for frame in frames][3] == (top + 1,)


@pytest.mark.parametrize("second", [5, 4])
def test_a_number_twice_or_going_back_is_an_error(second: int) -> None:
    video = device(Driver([Fill(5), Fill(second)]))
    video.start()
    video.read(1.0)
    with pytest.raises(DeviceAnswerError, match=f"found {second}, allowed above 5"):
        video.read(1.0)


def test_another_clock_than_the_monotonic_one_is_refused() -> None:
    video = device(Driver([Fill(5, flags=0)]))
    video.start()
    with pytest.raises(DeviceAnswerError, match="monotonic"):
        video.read(1.0)


def test_no_frame_within_the_bound_is_silence() -> None:
    driver = Driver()
    video = device(driver)
    video.start()
    with pytest.raises(DeviceSilentError, match=r"0\.5 s"):
        video.read(0.5)
    assert driver.now == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("driver", "found"),
    [(Driver(code=b"YUYV"), "'YUYV'"), (Driver(rows=5), "5 rows"), (Driver(rows=3), "3 rows")],
)
def test_a_format_that_was_not_asked_for_is_refused_and_the_node_closed(
    driver: Driver, found: str
) -> None:
    with pytest.raises(FramesError, match=found):
        device(driver).start()
    assert driver.open_now == 0


def test_compressed_frames_are_refused_by_name_with_the_reason() -> None:
    with pytest.raises(FramesError, match="MJPG is compressed and changes grey levels"):
        device(Driver(code=b"MJPG")).start()


def test_a_driver_that_grants_one_buffer_is_refused() -> None:
    driver = Driver(granted=1)
    with pytest.raises(DeviceAnswerError, match="found 1, allowed at least 2"):
        device(driver).start()
    assert (driver.open_now, driver.mapped_now) == (0, 0)


@pytest.mark.parametrize(
    ("code", "named"),
    [
        (errno.EBUSY, DeviceBusyError),
        (errno.ENODEV, DeviceAbsentError),
        (errno.EPERM, DeviceError),
        (errno.EINVAL, DeviceError),
    ],
)
@pytest.mark.parametrize("request_number", [QUERYCAP, S_INPUT, S_FMT, REQBUFS, QBUF, STREAMON])
def test_each_refusal_of_the_kernel_has_its_name_and_leaves_nothing_open(
    code: int, named: type[DeviceError], request_number: int
) -> None:
    driver = Driver(fails={request_number: code})
    with pytest.raises(DeviceError) as caught:
        device(driver).start()
    assert type(caught.value) is named
    assert (driver.open_now, driver.mapped_now) == (0, 0)


def test_a_camera_that_goes_away_while_streaming_is_absent() -> None:
    driver = Driver([Fill(0)])
    video = device(driver)
    video.start()
    driver.fails = {DQBUF: errno.ENODEV}
    with pytest.raises(DeviceAbsentError):
        video.read(1.0)


def test_a_frame_that_was_not_ready_after_all_is_waited_for() -> None:
    driver = Driver([Fill(0)])
    video = device(driver)
    video.start()
    driver.fails = {DQBUF: errno.EAGAIN}
    with pytest.raises(DeviceSilentError):
        video.read(0.01)


def test_a_camera_without_inputs_need_not_know_the_request() -> None:
    driver = Driver(fails={S_INPUT: errno.ENOTTY})
    camera = VideoDevice("/dev/video0", rows=ROWS, columns=COLUMNS, kernel=driver)
    camera.start()
    camera.close()
    with pytest.raises(DeviceError):
        device(driver).start()


def test_a_node_that_does_not_capture_is_refused() -> None:
    driver = Driver(capabilities=0x0400_0002)
    with pytest.raises(DeviceAnswerError, match="does not capture"):
        device(driver).check()
    assert driver.open_now == 0


def test_a_sign_of_life_leaves_the_node_closed_and_does_not_disturb_a_stream() -> None:
    driver = Driver()
    video = device(driver)
    video.check()
    assert driver.open_now == 0
    video.start()
    video.check()
    assert driver.open_now == 1


def test_reading_without_a_stream_is_an_error() -> None:
    with pytest.raises(DeviceError, match="start it first"):
        device(Driver()).read(1.0)


def test_the_real_kernel_names_an_absent_node_and_one_that_is_no_camera(tmp_path: Path) -> None:
    absent = VideoDevice(str(tmp_path / "video0"), rows=4, columns=6, kernel=LinuxKernel())
    with pytest.raises(DeviceAbsentError):
        absent.check()
    with pytest.raises(DeviceError, match="cannot query"):
        VideoDevice("/dev/null", rows=4, columns=6).check()
