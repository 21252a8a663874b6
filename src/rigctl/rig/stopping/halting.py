"""Brings to rest what the cut does not, and opens lost lines again; never on the way to a fire."""

from __future__ import annotations

import logging
from collections.abc import Callable

from rigctl.devices.roles import Actuator, Actuators
from rigctl.errors import RigError
from rigctl.rig.stopping.estop import EmergencyStop

_log = logging.getLogger(__name__)


def reopen(devices: Actuators, stop: EmergencyStop) -> None:
    """Open every line again that was lost, the cut-off's in the thread that owns it.

    Never raises a `RigError`: a line that stays away is named by whatever next needs it.
    """
    for part in (stop, devices.trigger, devices.regulator, devices.slide):
        if part is None:
            continue
        try:
            part.reopen()
        except RigError as error:
            _log.warning("a line was not opened again: %s", error)


def halt(devices: Actuators) -> tuple[str, ...]:
    """Stop the slide and set the regulators to 0 kPa; say of each what became of it.

    Never raises: each part is tried whatever the other does. Both acts are harmless when
    repeated, and so may open a line that was lost.
    """
    results = []
    if devices.slide is not None:
        results.append(_tried(devices.slide, devices.slide.stop, "stopped"))
    if devices.regulator is not None:
        results.append(_tried(devices.regulator, devices.regulator.vent, "set to 0 kPa"))
    return tuple(results)


def make_safe(devices: Actuators) -> str:
    """Drive the trigger to its safe level, on a line opened again if it was lost; never raises."""
    return _tried(devices.trigger, devices.trigger.make_safe, "safe")


def _tried(part: Actuator, act: Callable[[], None], done: str) -> str:
    try:
        part.reopen()
    except Exception:  # noqa: BLE001 - a line that only seems lost may still carry the act
        _log.exception("%s could not be reopened", part.name)
    try:
        act()
    except Exception as error:  # noqa: BLE001 - the other parts must be brought to rest too
        _log.exception("%s could not be brought to rest", part.name)
        return f"{part.name}: NOT {done} ({error})"
    return f"{part.name}: {done}"
