"""Stand-ins for the roles of a rig: they count, they can fail on command, they never wait."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from rigctl.cameras.capture import RecordingConfirmation
from rigctl.cameras.frames import FrameSequence
from rigctl.config import Configuration, load
from rigctl.devices.roles import Actuators, FireReceipt, Reading
from rigctl.rig.clock import Clock
from rigctl.rig.machine import Rig
from rigctl.settings import ShotSettings
from rigctl.store import ShotRecord, Store

SETTINGS = ShotSettings(pressure_a_kpa=40.0, pressure_b_kpa=40.0, offset_mm=6.0)
BOUND_S = 60.0
"""No test waits so long, on a machine however busy."""


class HandClock:
    """Time that moves only when told to; a wait moves it."""

    def __init__(self) -> None:
        self.now = 1000.0
        self.began = datetime(2026, 1, 31, 12, 0, tzinfo=UTC)
        self.step_s = 0.0

    def clock(self) -> Clock:
        return Clock(lambda: self.now, self.wall, self.pass_time)

    def wall(self) -> datetime:
        return self.began + timedelta(seconds=self.now - 1000.0 + self.step_s)

    def pass_time(self, seconds: float) -> None:
        self.now += seconds


@dataclass
class Part:
    """What all stand-ins share: a log of calls, and errors to raise, one for each name."""

    log: list[str]
    role: str
    errors: dict[str, Exception] = field(default_factory=dict)
    hooks: dict[str, Callable[[], None]] = field(default_factory=dict)

    @property
    def name(self) -> str:
        return f"{self.role} (stand-in)"

    def called(self, what: str) -> None:
        self.log.append(f"{self.role}.{what}")
        if what in self.hooks:
            self.hooks[what]()
        if what in self.errors:
            raise self.errors[what]

    def check(self) -> None:
        self.called("check")

    def reopen(self) -> None:
        self.called("reopen")

    def close(self) -> None:
        self.called("close")


@dataclass
class FakeTrigger(Part):
    """Counts fires by sequence number, and fires only what was armed."""

    clock: HandClock = field(default_factory=HandClock)
    fired: list[int] = field(default_factory=list)
    armed: int | None = None
    has_power: bool = True
    supply: Callable[[], bool] = lambda: True

    def arm(self, sequence: int, delay_us: float) -> None:
        self.called("arm")
        self.armed = sequence

    def fire(self, sequence: int) -> FireReceipt:
        self.fired.append(sequence)
        sent_at = self.clock.now
        self.called("fire")
        return FireReceipt(sequence, sent_at, self.clock.now, 123)

    def make_safe(self) -> None:
        self.called("make_safe")
        self.armed = None

    def powered(self) -> bool:
        self.called("powered")
        return self.has_power and self.supply()


@dataclass
class FakeRegulator(Part):
    """Reaches its set points after `lag_s` of the hand clock."""

    clock: HandClock = field(default_factory=HandClock)
    lag_s: float = 0.0
    error_kpa: float = 0.0
    age_s: float = 0.0
    _set: tuple[float, float] = (0.0, 0.0)
    _since: float = 0.0

    def set_pressure(self, a_kpa: float, b_kpa: float) -> None:
        self.called("set_pressure")
        self._set, self._since = (a_kpa, b_kpa), self.clock.now

    def vent(self) -> None:
        self.called("vent")
        self._set, self._since = (0.0, 0.0), self.clock.now

    def pressure(self) -> tuple[Reading, Reading]:
        self.called("pressure")
        reached = self.clock.now - self._since >= self.lag_s
        a, b = self._set if reached else (0.0, 0.0)
        at = self.clock.now - self.age_s
        return Reading(a + self.error_kpa, "kPa", at), Reading(b, "kPa", at)


@dataclass
class FakeSlide(Part):
    """Stands where it was sent, unless stuck."""

    clock: HandClock = field(default_factory=HandClock)
    moving: bool = False
    stuck: bool = False
    _at: float = 0.0

    def move_to(self, offset_mm: float) -> None:
        self.called("move_to")
        if not self.stuck:
            self._at = offset_mm

    def stop(self) -> None:
        self.called("stop")
        self.moving = False

    def position(self) -> Reading:
        self.called("position")
        return Reading(self._at, "mm", self.clock.now)

    def is_moving(self) -> bool:
        return self.moving


@dataclass
class FakeCutOff(Part):
    """Knows whether there is power, and tells waiting tests of each cut."""

    power: bool = False
    was_cut: threading.Event = field(default_factory=threading.Event)

    def cut(self) -> None:
        self.called("cut")
        self.power = False
        self.was_cut.set()

    def restore(self) -> None:
        self.called("restore")
        self.power = True


@dataclass
class FakeCapture(Part):
    """Delivers a short stack of known pixels."""

    clock: HandClock = field(default_factory=HandClock)
    lost: tuple[int, ...] = ()
    marked_late_s: float | None = None

    def start(self) -> RecordingConfirmation:
        self.called("start")
        return RecordingConfirmation("stand-in", self.clock.now, "picture count rises")

    def mark(self, late_s: float = 0.0) -> None:
        self.marked_late_s = late_s
        self.called("mark")

    def collect(self) -> FrameSequence:
        self.called("collect")
        return stack(lost=self.lost)

    def stop(self) -> None:
        self.called("stop")


def until(condition: Callable[[], bool]) -> None:
    """Return once the condition holds; fail when the bound is over."""
    deadline = time.monotonic() + BOUND_S
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.001)


def stack(frames: int = 4, lost: tuple[int, ...] = ()) -> FrameSequence:
    pixels = np.arange(frames * 192 * 240, dtype=np.int64).reshape(frames, 192, 240) % 251
    return FrameSequence(
        pixels=pixels.astype(np.uint8),
        times_s=np.arange(frames) / 1000.0,
        sequence=np.arange(frames, dtype=np.int64),
        lost=lost,
        source="stand-in",
    )


class Laboratory:
    """One rig of stand-ins over one store folder.

    `restart` is a daemon that was killed and came back, `start_again` one that ended clean.
    """

    def __init__(
        self,
        folder: Path,
        *,
        configuration: Configuration | None = None,
        threads: bool = False,
        free_mb: float = 1e6,
    ) -> None:
        self.folder, self.threads, self.free_mb = folder, threads, free_mb
        self.configuration = load() if configuration is None else configuration
        self.log: list[str] = []
        self.time = HandClock()
        self.trigger = FakeTrigger(self.log, "trigger", clock=self.time)
        self.regulator = FakeRegulator(self.log, "regulator", clock=self.time)
        self.slide = FakeSlide(self.log, "slide", clock=self.time)
        self.cut_off = FakeCutOff(self.log, "cut_off")
        self.trigger.supply = lambda: self.cut_off.power
        self.capture = FakeCapture(self.log, "capture", clock=self.time)
        self.to_analyse: list[str] = []
        self._keys = 0
        self.open()

    def open(self) -> None:
        self.store = Store(
            self.folder, busy_timeout_s=0.05, free_bytes=lambda _: int(self.free_mb * 1e6)
        )
        pusher = self.configuration.apparatus == "pusher"
        devices = Actuators(
            self.trigger,
            self.regulator if pusher else None,
            self.slide if pusher else None,
            self.cut_off,
        )
        spawn = {} if self.threads else {"spawn": lambda work: work()}
        self.rig = Rig(
            self.configuration,
            devices,
            self.capture,
            self.store,
            clock=self.time.clock(),
            analyse=self.to_analyse.append,
            **spawn,
        )
        self.recovery = self.rig.recover()

    def abandon(self) -> None:
        """Let go of the store without any of the rig's own closing, as a kill would."""
        self.rig._stop.close()
        self.store.close()

    def restart(self) -> None:
        self.abandon()
        self.open()

    def start_again(self) -> None:
        self.close()
        self.open()

    def close(self) -> None:
        self.rig.close()
        self.store.close()

    def arm(self, **changes: float) -> str:
        return self.rig.arm(SETTINGS.model_copy(update=changes), "anna").token

    def fire(self, token: str, key: str | None = None, body: str = "body") -> ShotRecord:
        if key is None:
            self._keys += 1
            key = f"key-{self._keys}"
        return self.rig.fire(token, key, body, actor="anna")

    def shoot(self) -> ShotRecord:
        self.time.pass_time(1.0)
        return self.fire(self.arm())

    @property
    def state(self) -> str:
        return str(self.rig.status().state)

    def journalled(self) -> list[tuple[str, str]]:
        return [(e.before, e.after) for e in self.store.journal.entries(limit=1000)]


class Blocked:
    """A call that waits until the test lets it go on, within a bound."""

    def __init__(self, part: Part, call: str) -> None:
        self.reached, self.go_on = threading.Event(), threading.Event()
        part.hooks[call] = self

    def __call__(self) -> None:
        self.reached.set()
        self.go_on.wait(BOUND_S)


def in_thread(work: Callable[[], None]) -> threading.Thread:
    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    return thread
