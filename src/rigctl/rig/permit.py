"""Whether a rig may fire at all, as far as people must have looked at it first."""

from __future__ import annotations

from typing import Protocol

from rigctl.rig.interlocks import Interlock
from rigctl.settings import ShotSettings


class Permit(Protocol):
    """What stands before the other interlocks: nothing moves while it refuses."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the operator is told meanwhile; returns at once."""

    def interlock(self, settings: ShotSettings) -> Interlock | None:
        """Return the condition for a shot with these settings; None where there is none."""


class NoPermitNeeded:
    """The permit of a rig that nobody has to look at first."""

    warnings: tuple[str, ...] = ()

    def interlock(self, settings: ShotSettings) -> Interlock | None:
        """Return None."""
        return None
