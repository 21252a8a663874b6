"""Spin that the air brakes."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import FlightEffect, Flying, Parameter, Values

KINEMATIC_VISCOSITY = 1.5e-5
"""Of air at 20 degrees Celsius, m^2/s."""


def accelerate(flying: Flying, values: Values) -> tuple[Floats, Floats]:
    """Return -k C_T rho |w| w R^5 / (2 I), with |w| C_T written so that it ends at w = 0."""
    rate = np.linalg.norm(flying.spin, axis=-1, keepdims=True)
    per_radius = KINEMATIC_VISCOSITY / flying.body.radius**2
    braking = 6.45 * np.sqrt(per_radius * rate) + 32.1 * per_radius
    torque = 0.5 * flying.air_density * flying.body.radius**5 * braking
    twist = -values[0] * torque / flying.body.inertia * flying.spin
    return np.zeros_like(flying.velocity), twist


EFFECT = FlightEffect(
    name="spin-decay",
    title="Decay of spin in air",
    parameters=(
        Parameter(
            symbol="k",
            unit="1",
            meaning="share of the torque of a sphere that turns in still air",
            plausible=(0.0, 5.0),
            step=1e-3,
            one_sided=True,
        ),
    ),
    formula="torque = k C_T rho w^2 R^5 / 2, C_T = 6.45 / Re^(1/2) + 32.1 / Re, Re = w R^2 / nu",
    source=(
        "S. C. R. Dennis, S. N. Singh and D. B. Ingham, J. Fluid Mech. 101, 257 (1980); "
        "O. Sawatzki, Acta Mech. 9, 159 (1970)"
    ),
    gives_away="spin falls along each track, by 2 rad/s^2 at 200 rad/s: invisible here, a control",
    confused_with=("exposure-offset", "frame-rate"),
    accelerate=accelerate,
)
