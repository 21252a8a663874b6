"""Quadratic drag of air that moves."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import FlightEffect, Flying, Parameter, Values

NOMINAL_DRAG = 0.42
"""Drag coefficient of a smooth sphere, 1e3 < Re < 1e5."""


def accelerate(flying: Flying, values: Values) -> tuple[Floats, Floats]:
    """Return -rho A / (2 m) [Cd |v| v + C0 (|v - u| (v - u) - |v| v)], C0 the nominal coefficient.

    At Cd = C0 this is drag in the wind u, exactly. The wind has a coefficient of its own because
    with Cd alone it would have no effect, and no derivative, where the drag is off; at another Cd
    the wind is u C0 / Cd.
    """
    area = np.pi * flying.body.radius**2
    factor = flying.air_density * area / (2 * flying.body.mass)
    still = _rush(flying.velocity)
    blown = _rush(flying.velocity - values[1:]) - still
    return -factor * (values[0] * still + NOMINAL_DRAG * blown), np.zeros_like(still)


def _rush(velocity: Floats) -> Floats:
    return np.asarray(np.linalg.norm(velocity, axis=-1, keepdims=True) * velocity)


def _component(axis: str, where: str) -> Parameter:
    return Parameter(
        symbol=f"u_{axis}",
        unit="m/s",
        meaning=f"wind {where}, at a drag coefficient of {NOMINAL_DRAG}",
        plausible=(-1.0, 1.0),
        step=1e-3,
    )


EFFECT = FlightEffect(
    name="wind",
    title="Air drag in a wind",
    parameters=(
        Parameter(
            symbol="Cd",
            unit="1",
            meaning="drag coefficient",
            plausible=(0.0, 0.6),
            step=1e-3,
            one_sided=True,
        ),
        _component("x", "downward"),
        _component("y", "to the right"),
        _component("z", "toward the camera"),
    ),
    formula="acceleration = -Cd rho A |v - u| (v - u) / (2 m)",
    source="Cd as for drag: L. Schiller and A. Naumann, Z. VDI 77, 318 (1935)",
    gives_away="drag that differs between spheres flying left and right: odd in v besides even",
    confused_with=("drag", "gravity-direction", "mass-mismatch"),
    contains=("drag",),
    accelerate=accelerate,
)
