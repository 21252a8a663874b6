"""A camera at a finite distance."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import CameraEffect, Parameter, Values
from analysis.setup import CameraSetup


def appear(position: Floats, camera: CameraSetup, values: Values) -> Floats:
    """Scale each view by nearness: X and Y by 1 / (1 - q Z), Z by 1 / (1 + q X).

    The scale of each view holds at the rig's origin, and each looks at the origin squarely; a line
    of sight elsewhere adds X to Z in proportion, which is what `mirror-angle` does.
    """
    del camera
    x, y, z = np.moveaxis(position, -1, 0)
    near = 1.0 - values[0] * z
    return np.stack([x / near, y / near, z / (1.0 + values[0] * x)], axis=-1)


EFFECT = CameraEffect(
    name="perspective",
    title="Perspective",
    parameters=(
        Parameter(
            symbol="q",
            unit="1/m",
            meaning="inverse of the distance from camera to rig",
            plausible=(0.0, 2.0),
            step=1e-4,
            one_sided=True,
        ),
    ),
    formula="x' = x / (1 - q z), y' = y / (1 - q z); in the mirror z' = z / (1 + q x)",
    source="pinhole camera: R. Hartley and A. Zisserman, Multiple View Geometry (2004), chapter 6",
    gives_away="lengths grow with z: spheres that drift toward the camera seem to part",
    confused_with=("radial-distortion", "image-scale"),
    appear=appear,
)
