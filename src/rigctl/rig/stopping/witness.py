"""Whether the power is as the cut-off was told, by the word of another device."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from rigctl.rig.clock import Clock

SETTLES_S = 0.5
"""Longest time from the command to what the witness sees: relay, supply, and its own answer, s."""

_POLL_S = 0.005

Witness = Callable[[], bool]
"""Says whether the actuators have power, or raises; a query, it moves nothing."""


@dataclass(frozen=True, slots=True)
class Sight:
    """What the witness saw.

    Attributes
    ----------
    powered
        None when it could not say.
    doubt
        Why the power is not known to be as it was told; None when it is seen to be.
    """

    powered: bool | None
    doubt: str | None


def look(witness: Witness, clock: Clock, *, wanted: bool) -> Sight:
    """Ask until the power is seen as wanted, for at most `SETTLES_S` and one answer."""
    deadline = clock.monotonic() + SETTLES_S
    try:
        while witness() is not wanted:
            if clock.monotonic() >= deadline:
                found = "no power" if wanted else "power"
                return Sight(not wanted, f"the trigger still reports {found} at its outputs")
            clock.wait(_POLL_S)
    except Exception as error:  # noqa: BLE001 - whatever breaks, the power has not been seen
        return Sight(None, f"the trigger cannot say whether its outputs have power ({error})")
    return Sight(wanted, None)
