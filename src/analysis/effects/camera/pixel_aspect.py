"""Rows that are not as far apart as columns."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import CameraEffect, Parameter, Values
from analysis.setup import CameraSetup


def appear(position: Floats, camera: CameraSetup, values: Values) -> Floats:
    """Stretch what is read from rows: X in the front view, Z in the top view."""
    del camera
    rows = np.array([1.0, 0.0, 1.0])
    return np.asarray(position * (1.0 + values[0] * rows))


EFFECT = CameraEffect(
    name="pixel-aspect",
    title="Aspect ratio of the pixels",
    parameters=(
        Parameter(
            symbol="a",
            unit="1",
            meaning="share by which lengths along rows come out longer than along columns",
            plausible=(-0.02, 0.02),
        ),
    ),
    formula="row' = (1 + a) row, in both views: x' = (1 + a) x, z' = (1 + a) z",
    source="shape of the pixels, and sampling of the analogue line on replay",
    gives_away="restitution changes with the angle of the normal; spheres are ellipses",
    confused_with=("finite-contact", "restitution-obliquity", "image-scale"),
    appear=appear,
)
