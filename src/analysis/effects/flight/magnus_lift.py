"""Lift of a spinning sphere across its flight."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import FlightEffect, Flying, Parameter, Values


def lift_coefficient(spin_ratio: Floats) -> Floats:
    """Return C_L = S / (2.2 S + 0.7), S = R |w x v| / v^2 the speed of the surface over v."""
    return spin_ratio / (2.2 * spin_ratio + 0.7)


def accelerate(flying: Flying, values: Values) -> tuple[Floats, Floats]:
    """Return k C_L rho A v^2 / (2 m) along w x v; spin about the line of flight does nothing."""
    across = np.cross(flying.spin, flying.velocity)
    rate = np.linalg.norm(across, axis=-1, keepdims=True)
    square = (flying.velocity**2).sum(axis=-1, keepdims=True)
    ratio = flying.body.radius * rate / np.maximum(square, 1e-12)
    force = 0.5 * flying.air_density * np.pi * flying.body.radius**2 * square
    along = across / np.maximum(rate, 1e-12)
    lift = values[0] * lift_coefficient(ratio) * force / flying.body.mass
    return lift * along, np.zeros_like(across)


EFFECT = FlightEffect(
    name="magnus-lift",
    title="Magnus lift",
    parameters=(
        Parameter(
            symbol="k",
            unit="1",
            meaning="share of the lift that the coefficient of sports balls gives",
            plausible=(0.0, 2.5),
            step=1e-3,
            one_sided=True,
        ),
    ),
    formula="acceleration = k C_L rho A v^2 / (2 m) along w x v, C_L = S / (2.2 S + 0.7)",
    source=(
        "rounded form of the fits of A. Stepanek, Am. J. Phys. 56, 138 (1988), tennis, and "
        "A. M. Nathan, Am. J. Phys. 76, 119 (2008), baseball; a smooth sphere at Re = 1e4 may "
        "lift less, and slow flow lifts most, C_L = 2 S (S. I. Rubinow and J. B. Keller, J. Fluid "
        "Mech. 11, 447 (1961)), which is k = 2.3 at S = 0.2"
    ),
    gives_away="tracks bend across their velocity, to the side that w x v says",
    confused_with=("drag", "wind", "gravity-direction"),
    accelerate=accelerate,
)
