"""Which forces act in a contact that lasts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Pushing = Literal["tsuji", "viscous", "hertz-dashpot", "linear"]
Dragging = Literal["elongation", "increment", "damped-while-sticking", "bristles"]


@dataclass(frozen=True, slots=True)
class Forces:
    """A contact that lasts; the defaults are those of the rig's nylon spheres.

    Parameters
    ----------
    push, drag
        The normal and the tangential force.
    duration_s
        Of an undamped contact at 1 m/s.
    stiffness_ratio, damping_ratio
        Tangential over normal stiffness, and the tangential dashpot over its critical value.
    whole_levers
        Whether the levers keep the spheres' radii instead of ending midway.
    """

    push: Pushing = "tsuji"
    drag: Dragging = "elongation"
    duration_s: float = 1.8776e-4
    stiffness_ratio: float = 0.15
    damping_ratio: float = 0.05
    whole_levers: bool = False
