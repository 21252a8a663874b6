"""Gravity that differs from the stated value."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import FlightEffect, Flying, Parameter, Values


def accelerate(flying: Flying, values: Values) -> tuple[Floats, Floats]:
    """Return the excess over the stated g, along +X."""
    push = np.zeros_like(flying.velocity)
    push[..., 0] = values[0]
    return push, np.zeros_like(push)


EFFECT = FlightEffect(
    name="gravity-value",
    title="Value of gravity",
    parameters=(
        Parameter(
            symbol="dg",
            unit="m/s^2",
            meaning="excess of gravity over the stated value",
            plausible=(-0.045, 0.03),
            step=1e-4,
        ),
    ),
    formula="g -> g + dg",
    source="9.764 to 9.834 m/s^2 at sea level and on mountains, against the standard 9.80665",
    gives_away="the fall alone, and in neither velocities nor spins",
    confused_with=("frame-rate", "buoyancy"),
    accelerate=accelerate,
)
