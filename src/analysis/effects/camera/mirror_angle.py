"""A mirror that does not stand at 45 degrees."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import CameraEffect, Parameter, Values
from analysis.setup import CameraSetup


def appear(position: Floats, camera: CameraSetup, values: Values) -> Floats:
    """Turn the top view by 2 d: z' = z cos 2d - x sin 2d; X and Y come from the front view."""
    del camera
    x, y, z = np.moveaxis(position, -1, 0)
    turned = z * np.cos(2 * values[0]) - x * np.sin(2 * values[0])
    return np.stack([x, y, turned], axis=-1)


EFFECT = CameraEffect(
    name="mirror-angle",
    title="Angle of the mirror",
    parameters=(
        Parameter(
            symbol="d",
            unit="rad",
            meaning="turn of the mirror's normal about Y, from +X toward +Z",
            plausible=(-0.02, 0.02),
        ),
    ),
    formula="z' = z cos 2d - x sin 2d",
    source="law of reflection: a mirror turned by d turns its image by 2 d (thesis, section 3.2)",
    gives_away="depth changes with height: spheres that fall seem to drift along Z",
    confused_with=("camera-roll", "gravity-direction", "perspective"),
    appear=appear,
)
