"""Rig axes that are not plumb."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import FlightEffect, Flying, Parameter, Values


def accelerate(flying: Flying, values: Values) -> tuple[Floats, Floats]:
    """Return g (d - x), where d is the unit vector along (1, tan p_y, tan p_z)."""
    down = np.array([1.0, np.tan(values[0]), np.tan(values[1])])
    down /= np.linalg.norm(down)
    push = np.broadcast_to(flying.gravity * (down - [1.0, 0.0, 0.0]), flying.velocity.shape)
    return push, np.zeros_like(flying.velocity)


def _tilt(axis: str, where: str) -> Parameter:
    return Parameter(
        symbol=f"p_{axis}",
        unit="rad",
        meaning=f"tilt of gravity from X {where}",
        plausible=(-0.035, 0.035),
    )


EFFECT = FlightEffect(
    name="gravity-direction",
    title="Direction of gravity",
    parameters=(_tilt("y", "to the right"), _tilt("z", "toward the camera")),
    formula="gravity = g (1, tan p_y, tan p_z) / |(1, tan p_y, tan p_z)|",
    source="mounting of camera and rig, within 2 degrees of the plumb line",
    gives_away="both spheres fall sideways, before contact as after it",
    confused_with=("camera-roll", "mass-mismatch", "wind"),
    accelerate=accelerate,
)
