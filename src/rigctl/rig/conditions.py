"""Reads every interlock of this rig, and adjusts pressure and offset until both are reached."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from datetime import datetime

from rigctl.cameras.capture import RecordingConfirmation
from rigctl.devices.roles import PowerQuery
from rigctl.errors import RigError, StoreError
from rigctl.rig.interlocks import Interlock, fresh, within
from rigctl.rig.parts import Bench
from rigctl.rig.permit import Permit
from rigctl.rig.stopping.estop import EmergencyStop
from rigctl.rig.stopping.halting import halt
from rigctl.settings import ShotSettings


class Conditions:
    """What is asked of every part before arming, and again just before the fire command.

    A part that does not answer is a tripped condition, not an exception: all that fails is
    gathered and reported together.
    """

    def __init__(self, bench: Bench, stop: EmergencyStop, permit: Permit) -> None:
        self._permit = permit
        self._limits, self._devices = bench.configuration.limits, bench.devices
        self._capture, self._store, self._clock = bench.capture, bench.store, bench.clock
        self._stop, self._frames_bytes = stop, bench.configuration.camera.frames_bytes
        self._rests_since: float | None = None
        self._clocks = self._both_clocks()

    def shot_ended(self) -> None:
        """Start the cool-down."""
        self._rests_since = self._clock.monotonic()

    def adjusted(self, settings: ShotSettings) -> tuple[Interlock, ...]:
        """Read what takes time to be reached: pressure, offset and the cool-down."""
        found = [*self._pressure(settings), *self._offset(settings), self._cool_down()]
        return fresh(found, self._clock.monotonic(), self._limits.reading_max_age_s)

    def all(
        self, settings: ShotSettings, recording: RecordingConfirmation | None = None
    ) -> tuple[Interlock, ...]:
        """Read every condition; once frames are recorded, the confirmation speaks for the camera.

        From then on the room for their frames on the disk is held, until it is given back.

        Ages are taken after the last reading, so a slow part makes the earlier ones stale.
        """
        found = [
            *self.permit(settings),
            *self._pressure(settings),
            *self._offset(settings),
            self._camera(recording),
            self._trigger(),
            self.cut_off(),
            self._latch(),
            self._cool_down(),
            self._disk(),
            self._writable(),
            self._wall_clock(),
            *([] if recording is None else [self._room()]),
        ]
        return fresh(found, self._clock.monotonic(), self._limits.reading_max_age_s)

    def permit(self, settings: ShotSettings) -> tuple[Interlock, ...]:
        """Read what stands before all others; empty where nothing does."""
        found = self._permit.interlock(settings)
        return () if found is None else (found,)

    def cut_off(self) -> Interlock:
        """Read the cut-off: its sign of life, and whether it was told to give power."""
        source = self._devices.cut_off.name
        try:
            self._stop.check()
        except RigError as error:
            return self._silent("cut_off", source, error)
        powered = self._stop.powered
        value = "restored" if powered else "cut"
        todo = "release the rig"
        return self._word("cut_off", powered, value, limit="restored", source=source, todo=todo)

    def _pressure(self, settings: ShotSettings) -> Iterator[Interlock]:
        regulator = self._devices.regulator
        if regulator is None:
            return
        todo = "wait for the regulator, or check its supply"
        try:
            readings = regulator.pressure()
        except RigError as error:
            yield self._silent("pressure", regulator.name, error)
            return
        wanted = (settings.pressure_a_kpa, settings.pressure_b_kpa)
        tolerance = self._limits.pressure_tolerance_kpa
        for letter, reading, target in zip("ab", readings, wanted, strict=True):
            name, at = f"pressure_{letter}", reading.read_at
            yield within(
                name,
                reading.value,
                target,
                tolerance,
                unit="kPa",
                source=regulator.name,
                read_at=at,
                todo=todo,
            )

    def _offset(self, settings: ShotSettings) -> Iterator[Interlock]:
        slide = self._devices.slide
        if slide is None:
            return
        try:
            moving = slide.is_moving()
            asked_at = self._clock.monotonic()
            reading = slide.position()
        except RigError as error:
            yield self._silent("offset", slide.name, error)
            return
        yield within(
            "offset",
            reading.value,
            settings.offset_mm,
            self._limits.offset_tolerance_mm,
            unit="mm",
            source=slide.name,
            read_at=reading.read_at,
            todo="wait for the slide, or check that nothing blocks it",
        )
        word = "moving" if moving else "at rest"
        todo = "wait until the slide rests"
        yield Interlock("slide", not moving, word, "at rest", "", slide.name, asked_at, todo)

    def _camera(self, recording: RecordingConfirmation | None) -> Interlock:
        if recording is None:
            return self._asked("camera", self._capture.name, self._capture.check)
        value, todo = f"recording ({recording.evidence})", "check the camera"
        return Interlock("camera", True, value, "recording", "", recording.by, recording.at, todo)

    def _trigger(self) -> Interlock:
        trigger = self._devices.trigger
        answers = self._asked("trigger", trigger.name, trigger.check)
        if not answers.holds or not isinstance(trigger, PowerQuery):
            return answers
        try:
            powered = trigger.powered()
        except RigError as error:
            return self._silent("trigger", trigger.name, error)
        # A cut-off on the wrong board or channel gives power elsewhere, and knows nothing of it.
        todo = (
            "the cut-off was restored: check its port and channel in the configuration, the "
            "switch at hand, and the supply of the actuators"
            if self._stop.powered
            else "release the rig, which gives power back"
        )
        value = "powered" if powered else "without power"
        source = trigger.name
        return self._word("trigger", powered, value, limit="powered", source=source, todo=todo)

    def _latch(self) -> Interlock:
        latch = self._stop.latch
        value = "none" if latch is None else f"stopped by {latch.actor}: {latch.reason}"
        todo = "release the rig with a reason"
        source = "emergency stop"
        return self._word("latch", latch is None, value, limit="none", source=source, todo=todo)

    def _cool_down(self) -> Interlock:
        now, needed = self._clock.monotonic(), self._limits.cool_down_s
        rested = now - self._rests_since if self._rests_since is not None else needed
        limit, todo = f"at least {needed:g}", "wait"
        return Interlock("cool_down", rested >= needed, rested, limit, "s", "rig", now, todo)

    def _disk(self) -> Interlock:
        now, needed = self._clock.monotonic(), self._limits.free_disk_mb
        try:
            free = self._store.free_mb()
        except RigError as error:
            return self._silent("disk", str(self._store.path), error)
        limit, source = f"at least {needed:g}", str(self._store.path)
        todo = "free disk space, or name another store folder"
        return Interlock("disk", free >= needed, free, limit, "MB", source, now, todo)

    def _room(self) -> Interlock:
        """Hold the room on the disk that the frames of a shot take."""
        now, source = self._clock.monotonic(), str(self._store.path)
        try:
            self._store.folders.room.hold(self._frames_bytes)
        except StoreError as error:
            free, needed = error.value or error.what, error.limit or "room"
            return Interlock("room", False, free, needed, "", source, now, error.todo or "")
        held = f"{self._frames_bytes} bytes held"
        return Interlock("room", True, held, "room for all frames", "", source, now, "")

    def _writable(self) -> Interlock:
        return self._asked("store", str(self._store.path), self._store.check)

    def _wall_clock(self) -> Interlock:
        wall, monotonic = self._both_clocks()
        step = (wall - self._clocks[0]).total_seconds() - (monotonic - self._clocks[1])
        # Said once: the operator is told, and the time as it is now becomes the reference.
        self._clocks = (wall, monotonic)
        allowed = self._limits.clock_step_s
        return Interlock(
            "clock",
            abs(step) <= allowed,
            step,
            f"a step of at most {allowed:g}",
            "s",
            "wall clock",
            monotonic,
            "check the clock of the host, then arm again",
        )

    def _both_clocks(self) -> tuple[datetime, float]:
        return self._clock.wall(), self._clock.monotonic()

    def _asked(self, name: str, source: str, check: Callable[[], None]) -> Interlock:
        try:
            check()
        except RigError as error:
            return self._silent(name, source, error)
        return self._word(name, True, "answers", limit="an answer", source=source, todo="")

    def _silent(self, name: str, source: str, error: RigError) -> Interlock:
        todo = error.todo or "check the part"
        value, limit = error.what, "an answer"
        if error.value is not None:
            value, limit = f"{error.what} ({error.value})", error.limit or limit
        return self._word(name, False, value, limit=limit, source=source, todo=todo)

    def _word(
        self, name: str, holds: bool, value: str, *, limit: str, source: str, todo: str
    ) -> Interlock:
        now = self._clock.monotonic()
        return Interlock(name, holds, value, limit, "", source, now, todo)


POLL_S = 0.02
"""Pause between two looks at pressure and offset, s."""

LOOKS = 2
"""Looks in a row that must be good: one alone may catch a value that is only passing."""


def adjust(
    settings: ShotSettings, bench: Bench, conditions: Conditions, stop: EmergencyStop
) -> None:
    """Give the set points and return when they are reached, the time is over, or a stop came.

    Whether they were reached is for the interlocks to say, which name what was not. When a stop
    came, slide and regulators are halted before it returns or raises.

    Raises
    ------
    DeviceError
        Regulator or slide did not take the command.
    """
    try:
        _give_set_points(settings, bench, stop)
        _await_set_points(settings, bench, conditions, stop)
    finally:
        # The stop halts them too, but a set point may have left here after it had done so.
        if stop.latch is not None:
            halt(bench.devices)


def _give_set_points(settings: ShotSettings, bench: Bench, stop: EmergencyStop) -> None:
    regulator, slide = bench.devices.regulator, bench.devices.slide
    if regulator is not None and stop.latch is None:
        regulator.set_pressure(settings.pressure_a_kpa, settings.pressure_b_kpa)
    if slide is not None and stop.latch is None:
        slide.move_to(settings.offset_mm)
    tubes, a_deg, b_deg = bench.devices.tubes, settings.angle_a_deg, settings.angle_b_deg
    if tubes is not None and a_deg is not None and b_deg is not None and stop.latch is None:
        tubes.turn_tubes(a_deg, b_deg)


def _await_set_points(
    settings: ShotSettings, bench: Bench, conditions: Conditions, stop: EmergencyStop
) -> None:
    clock = bench.clock
    deadline = clock.monotonic() + bench.configuration.limits.settle_timeout_s
    good = 0
    while good < LOOKS and stop.latch is None and clock.monotonic() < deadline:
        reached = all(condition.holds for condition in conditions.adjusted(settings))
        good = good + 1 if reached else 0
        if good < LOOKS and stop.latch is None:
            clock.wait(POLL_S)
