"""A wrong scale of the images."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import CameraEffect, Parameter, Values
from analysis.setup import CameraSetup


def appear(position: Floats, camera: CameraSetup, values: Values) -> Floats:
    """Return all lengths (1 + s) times as long, about the rig's origin."""
    del camera
    return np.asarray(position * (1.0 + values[0]))


EFFECT = CameraEffect(
    name="image-scale",
    title="Image scale",
    parameters=(
        Parameter(
            symbol="s",
            unit="1",
            meaning="share by which lengths come out too long",
            plausible=(-0.01, 0.01),
        ),
    ),
    formula="x' = (1 + s) x, in both views",
    source="edge bias of q px on a diameter of D px: s = -q / D (thesis, section 5)",
    gives_away="touching distance, gravity and translation against spin, all by one share",
    confused_with=("frame-rate", "gravity-value"),
    appear=appear,
)
