"""A plate that does not lie as stated: its normal leans from the stated one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.arrays import Floats
from analysis.collision.operator import Encounter, Operator, Outcome
from analysis.effects.effect import ContactEffect, Parameter, Values

NEARLY_UP = -0.9
"""X of a normal below which the shortest turn from +X is no smooth function of it."""


def wrap(operator: Operator, values: Values) -> Operator:
    """Turn the normal of every contact."""

    def changed(encounter: Encounter) -> Outcome:
        return operator(replace(encounter, normal=leaning(encounter.normal, values)))

    return changed


def leaning(normal: Floats, values: Values) -> Floats:
    """Return unit normals (S, 3) turned by so much, rad: a level plate's toward +Y and +Z."""
    toward_y, toward_z = tangents(normal)
    leans = normal + values[0] * toward_y + values[1] * toward_z
    return np.asarray(leans / np.linalg.norm(leans, axis=1, keepdims=True))


def tangents(normal: Floats) -> tuple[Floats, Floats]:
    """Return two unit vectors (S, 3) along a plate: Y and Z, turned as X was to its normal (S, 3).

    By the shortest turn, from -X where the normal is nearly that.
    """
    begin = np.where(normal[:, :1] < NEARLY_UP, -1.0, 1.0) * np.array([1.0, 0.0, 0.0])
    middle = (normal + begin) / (1.0 + (normal * begin).sum(axis=1, keepdims=True))
    toward_y = np.array([0.0, 1.0, 0.0]) - normal[:, 1:2] * middle
    toward_z = np.array([0.0, 0.0, 1.0]) - normal[:, 2:3] * middle
    return toward_y, toward_z


def _toward(axis: str) -> Parameter:
    return Parameter(
        symbol=axis.lower(),
        unit="rad",
        meaning=f"lean of the normal, of a level plate toward +{axis}",
        plausible=(-0.1, 0.1),
    )


EFFECT = ContactEffect(
    name="plate-tilt",
    title="Tilt of the plate",
    parameters=(_toward("Y"), _toward("Z")),
    formula="n = (1, y, z) / |(1, y, z)|, turned as the stated normal is from (1, 0, 0)",
    source="geometry of reflection at an inclined plane",
    gives_away="spheres that fall straight leave to one side, without turning as friction would",
    confused_with=("gravity-direction", "camera-roll"),
    wrap=wrap,
)
"""Takes part in every campaign of a sphere on a plate, as an error of stated size; of two spheres
it has no meaning."""
