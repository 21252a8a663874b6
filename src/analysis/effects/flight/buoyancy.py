"""The air that a sphere displaces and carries along."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import FlightEffect, Flying, Parameter, Values


def accelerate(flying: Flying, values: Values) -> tuple[Floats, Floats]:
    """Return what buoyancy and added mass take from g, b times, along -X.

    A sphere of x times the air's mass falls with g (1 - x) / (1 + x / 2); x = rho_air / rho.
    """
    displaced = flying.air_density * 4 / 3 * np.pi * flying.body.radius**3
    ratio = displaced / flying.body.mass
    loss = 1.5 * ratio / (1 + 0.5 * ratio)
    push = np.zeros_like(flying.velocity)
    push[..., 0] = -values[0] * loss * flying.gravity
    return push, np.zeros_like(push)


EFFECT = FlightEffect(
    name="buoyancy",
    title="Buoyancy and added mass of the air",
    parameters=(
        Parameter(
            symbol="b",
            unit="1",
            meaning="share of the theory's loss of g (0.16 % for nylon in air)",
            plausible=(0.0, 1.2),
            step=1e-2,
            one_sided=True,
        ),
    ),
    formula="g -> g (1 - x) / (1 + x / 2) at b = 1, x = rho_air / rho",
    source="H. Lamb, Hydrodynamics, 6th ed. (1932), art. 92: added mass of half the displaced air",
    gives_away="the fall alone, too slow by 0.16 %: nothing in these shots tells it from g",
    confused_with=("gravity-value", "frame-rate"),
    accelerate=accelerate,
)
