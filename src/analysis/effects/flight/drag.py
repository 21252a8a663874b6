"""Quadratic drag of the air."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import FlightEffect, Flying, Parameter, Values


def accelerate(flying: Flying, values: Values) -> tuple[Floats, Floats]:
    """Return -Cd rho A |v| v / (2 m)."""
    area = np.pi * flying.body.radius**2
    speed = np.linalg.norm(flying.velocity, axis=-1, keepdims=True)
    factor = values[0] * flying.air_density * area / (2 * flying.body.mass)
    return -factor * speed * flying.velocity, np.zeros_like(flying.velocity)


EFFECT = FlightEffect(
    name="drag",
    title="Quadratic air drag",
    parameters=(
        Parameter(
            symbol="Cd",
            unit="1",
            meaning="drag coefficient",
            plausible=(0.0, 1.5),
            step=1e-3,
            one_sided=True,
        ),
    ),
    formula="acceleration = -Cd rho A |v| v / (2 m)",
    source="Cd 0.4 to 0.45 at 1e3 < Re < 1e5: L. Schiller and A. Naumann, Z. VDI 77, 318 (1935)",
    gives_away="tracks bend against their own velocity, evenly in v; seen in long tracks only",
    confused_with=("wind", "magnus-lift"),
    accelerate=accelerate,
    proportional=True,
)
