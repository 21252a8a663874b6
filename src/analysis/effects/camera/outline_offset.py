"""Outlines that are seen beside their spheres, alike in all shots.

No effect that is looked for: shading and blur that are not quite as learned move a disc by some
hundredths of a pixel at its place in the rig's light. Only the offset of one sphere against the
other matters.
"""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import CameraEffect, Parameter, Values
from analysis.setup import CameraSetup


def appear(position: Floats, camera: CameraSetup, values: Values) -> Floats:
    """Return the centres of a and b (..., 2, 3) as seen: b off by a constant of the rig."""
    del camera
    seen = np.array(position)
    seen[..., 1, :] += values
    return seen


EFFECT = CameraEffect(
    name="outline-offset",
    title="Outlines off their spheres",
    parameters=tuple(
        Parameter(
            symbol=f"d_{axis}",
            unit="m",
            meaning=f"outline of sphere b from its centre, less that of sphere a, along {axis}",
            plausible=(-1e-4, 1e-4),
            step=1e-7,
        )
        for axis in "xyz"
    ),
    formula="centre of b seen = centre + d",
    source="shading and blur that are not quite as learned (decision 0014)",
    gives_away="spheres touch nearer or farther than their diameters, by as much in every shot",
    confused_with=("radius-mismatch", "image-scale", "finite-contact"),
    appear=appear,
)
