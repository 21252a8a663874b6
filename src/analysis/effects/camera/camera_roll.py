"""A camera turned about its line of sight."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import CameraEffect, Parameter, Values
from analysis.setup import CameraSetup


def appear(position: Floats, camera: CameraSetup, values: Values) -> Floats:
    """Turn rows and columns of both views by s.

    No rotation of space: the top view shows Z along its rows, which mix with the same columns.
    """
    del camera
    x, y, z = np.moveaxis(position, -1, 0)
    cosine, sine = np.cos(values[0]), np.sin(values[0])
    return np.stack([x * cosine - y * sine, y * cosine + x * sine, z * cosine + y * sine], axis=-1)


EFFECT = CameraEffect(
    name="camera-roll",
    title="Roll of the camera",
    parameters=(
        Parameter(
            symbol="s",
            unit="rad",
            meaning="turn of the picture, from rows (down) toward columns (right)",
            plausible=(-0.035, 0.035),
        ),
    ),
    formula="x' = x cos s - y sin s, y' = y cos s + x sin s, z' = z cos s + y sin s",
    source="rotation of the image plane, acting on the front view and on the mirror alike",
    gives_away="depth changes along the line of flight; spheres fall to one side",
    confused_with=("gravity-direction", "mirror-angle"),
    appear=appear,
)
