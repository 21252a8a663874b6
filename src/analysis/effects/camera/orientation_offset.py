"""Orientations that are seen turned against their spheres, alike in all shots.

No effect that is looked for: shading that is not quite as learned turns all that is seen of a
sphere by some hundredths of a degree about axes of the rig. Where it is at rest nothing shows this;
a spin is seen turned as well, and so is what a contact adds to it.
"""

from __future__ import annotations

from analysis.arrays import Floats
from analysis.effects.effect import OrientationEffect, Parameter, Values


def turned(values: Values) -> Floats:
    """Return the rotation vectors of a and b, rad, rig axes, shape (2, 3)."""
    return values.reshape(2, 3)


def _about(sphere: str, axis: str) -> Parameter:
    return Parameter(
        symbol=f"r_{sphere}{axis}",
        unit="rad",
        meaning=f"turn of all orientations that are seen of sphere {sphere}, about {axis}",
        plausible=(-1e-2, 1e-2),
        step=1e-6,
    )


EFFECT = OrientationEffect(
    name="orientation-offset",
    title="Orientations turned against their spheres",
    parameters=tuple(_about(sphere, axis) for sphere in "ab" for axis in "xyz"),
    formula="orientation seen = exp(r) R, and so spin seen = exp(r) omega",
    source="shading that is not quite as learned (decision 0039)",
    gives_away=(
        "in every shot the change of a sphere's spin points off the direction of friction, by the "
        "same small turn"
    ),
    confused_with=("torsional-friction", "outline-offset"),
    turned=turned,
)
