"""A number of the camera as the shots show it, and the effect that carries it into the model."""

from __future__ import annotations

import math
from dataclasses import dataclass

SEEN_SIGMAS = 3.0


@dataclass(frozen=True, slots=True)
class Estimate:
    """One estimate.

    Attributes
    ----------
    name
        What is estimated, as a table shows it.
    value, sigma
        With its standard error, in `unit`.
    unit
        As in the effect's parameter, or px/m.
    useful
        Error below which the estimate is useful: the range that is plausible for a rig.
    none
        Value of a camera without this fault; None: there is no such value.
    effect
        Name of the model's effect for it.
    in_poses
        The measured poses take it into account; the effect then carries what is left of it.
    how
        Feature of the images that determines it.
    """

    name: str
    value: float
    sigma: float
    unit: str
    useful: float
    none: float | None
    effect: str
    in_poses: bool
    how: str

    @property
    def finite(self) -> bool:
        """Whether the shots give any estimate."""
        return math.isfinite(self.sigma)

    @property
    def determined(self) -> bool:
        """Whether its error is below `useful`."""
        return self.sigma < self.useful

    @property
    def found(self) -> bool:
        """Whether it differs from a camera without this fault by SEEN_SIGMAS of its error."""
        away = 0.0 if self.none is None else abs(self.value - self.none)
        return self.determined and away > SEEN_SIGMAS * self.sigma
