"""A plate that does not lie level: its normal leans from the vertical."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.collision.operator import Encounter, Floats, Operator, Outcome
from analysis.effects.effect import ContactEffect, Parameter, Values


def wrap(operator: Operator, values: Values) -> Operator:
    """Turn the normal of every contact toward +Y and +Z."""

    def changed(encounter: Encounter) -> Outcome:
        return operator(replace(encounter, normal=leaning(encounter.normal, values)))

    return changed


def leaning(normal: Floats, values: Values) -> Floats:
    """Return unit normals (S, 3) turned toward +Y and +Z by so much, rad."""
    leans = normal + np.array([0.0, values[0], values[1]])
    return np.asarray(leans / np.linalg.norm(leans, axis=1, keepdims=True))


def _toward(axis: str) -> Parameter:
    return Parameter(
        symbol=axis.lower(),
        unit="rad",
        meaning=f"lean of the plate's normal toward +{axis}",
        plausible=(-0.1, 0.1),
    )


EFFECT = ContactEffect(
    name="plate-tilt",
    title="Tilt of the plate",
    parameters=(_toward("Y"), _toward("Z")),
    formula="n = (1, y, z) / |(1, y, z)|",
    source="geometry of reflection at an inclined plane",
    gives_away="spheres that fall straight leave to one side, without turning as friction would",
    confused_with=("gravity-direction", "camera-roll"),
    wrap=wrap,
)
"""Takes part in every campaign of a sphere on a plate, as an error of stated size; of two spheres
it has no meaning."""
