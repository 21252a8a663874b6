"""Sets pressure and offset and waits, within a bound, until both are reached."""

from __future__ import annotations

from rigctl.rig.conditions import Conditions
from rigctl.rig.parts import Bench
from rigctl.rig.stopping.estop import EmergencyStop
from rigctl.rig.stopping.halting import halt
from rigctl.settings import ShotSettings

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
