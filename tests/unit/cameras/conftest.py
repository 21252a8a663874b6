"""Time that moves only when somebody waits, and a recorder of a few lines."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from rigctl.devices.ektapro import RecorderMode, RecorderStatus, RecordingFormat, TapePlace
from rigctl.errors import DeviceAnswerError, DeviceSilentError


class FakeTime:
    """Monotonic seconds; each wait moves them on, and what is due then happens."""

    def __init__(self) -> None:
        self.now = 1000.0

    def clock(self) -> float:
        return self.now

    def wait(self, seconds: float) -> None:
        assert seconds >= 0
        self.now += seconds


class FakeRecorder:
    """A tape at 1000 pictures/s that takes 0.1 s to run up; faults are set by the test."""

    name = "recorder"

    def __init__(self, time: FakeTime) -> None:
        self.time, self.calls = time, list[str]()
        self.starts, self.granted = True, RecordingFormat(1000, 192)
        self.session, self.started_at, self.stopped_at = 0, 0.0, 0.0
        self.running = False
        self.marked: list[int] = []
        self.mark_is_answered, self.mark_takes_s, self.ends_after = True, 0.0, 10**9
        self.left_s, self.left_after_erase_s = 30.0, 30.0
        self.refuses: set[str] = set()
        self.closed = 0
        self.has_gamma, self.exponent = True, 1.0
        self.place_on_tape = 0
        self.on_transfer: Callable[[int, int, str], None] = lambda first, count, name: None

    def _note(self, call: str) -> None:
        self.calls.append(call)
        if call in self.refuses:
            raise DeviceAnswerError(f"{call} was refused", part=self.name)

    def check(self) -> None:
        self._note("check")

    def record(self) -> int:
        self._note("record")
        self.run()
        return self.session

    def run(self) -> None:
        """What RECORD and the closing contact do."""
        if self.starts:
            self.session, self.running, self.started_at = self.session + 1, True, self.time.now
            self.marked = []

    def stop(self) -> None:
        self._note("stop")
        if self.running:
            self.running, self.stopped_at = False, self.time.now

    def set_rate(self, full_frames_per_s: int, pictures_per_frame: int) -> RecordingFormat:
        self._note("rate")
        return self.granted

    def pictures(self) -> int:
        end = self.time.now if self.running else self.stopped_at
        ran_s = end - self.started_at - 0.1
        return min(self.ends_after, max(0, round(ran_s * 1000)))

    def status(self) -> RecorderStatus:
        mode = RecorderMode.STOP
        if self.running:
            up = self.time.now >= self.started_at + 0.1
            mode = RecorderMode.RECORD if up else RecorderMode.STARTING
        if self.running and self.pictures() >= self.ends_after:
            mode = RecorderMode.STOP
        return RecorderStatus(mode, self.session, self.pictures(), self.left_s, TapePlace.MIDDLE)

    def mark(self) -> int:
        self._note("mark")
        self.time.now += self.mark_takes_s
        self.marked.append(self.pictures())
        if not self.mark_is_answered:
            raise DeviceSilentError("no answer to MARK", part=self.name)
        return self.marked[-1]

    def marks(self) -> tuple[int, ...]:
        self._note("marks")
        return tuple(self.marked)

    def sessions(self) -> dict[int, int]:
        return {1: 100}

    def erase(self) -> None:
        self._note("erase")
        self.left_s = self.left_after_erase_s

    def set_gamma(self, gamma: float) -> None:
        self._note("gamma")
        self.exponent = gamma

    def transfer(self, first: int, count: int, name: str) -> None:
        self._note("transfer")
        self.on_transfer(first, count, name)

    def search(self, picture: int) -> int:
        self._note("search")
        self.place_on_tape = picture
        return picture

    def step(self, by: int) -> int:
        self._note("step")
        self.place_on_tape += by
        return self.place_on_tape

    def picture(self) -> int:
        return self.place_on_tape

    def close(self) -> None:
        self.closed += 1


@pytest.fixture
def time() -> FakeTime:
    return FakeTime()


@pytest.fixture
def recorder(time: FakeTime) -> FakeRecorder:
    return FakeRecorder(time)
