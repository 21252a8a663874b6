"""A lens whose magnification changes from the middle of the frame to its corners."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.effects.camera.frame_place import frame_places
from analysis.effects.effect import CameraEffect, Parameter, Values
from analysis.imaging.views import View
from analysis.setup import CameraSetup


def appear(position: Floats, camera: CameraSetup, values: Values) -> Floats:
    """Move each image point away from the frame's centre by k r^2 of its distance.

    The top view has its own place in the frame: Z is distorted there. Without a stated scale the
    place in the frame is not known, and nothing is moved.
    """
    scale = camera.scale_px_per_m
    if scale is None:
        return position
    corner = np.hypot(camera.height_px, camera.width_px) / 2
    moved = position.copy()
    for view, place in frame_places(position, camera, scale).items():
        square = (place**2).sum(axis=-1, keepdims=True) / corner**2
        shift = values[0] * square * place / scale
        if view is View.FRONT:
            moved[..., :2] += shift
        else:
            moved[..., 2] -= shift[..., 0]
    return moved


EFFECT = CameraEffect(
    name="radial-distortion",
    title="Radial distortion of the lens",
    parameters=(
        Parameter(
            symbol="k1",
            unit="1",
            meaning="share by which a corner lies too far out",
            plausible=(-0.05, 0.05),
        ),
    ),
    formula="r' = r (1 + k1 r^2) about the frame's centre, r = 1 at a corner",
    source="D. C. Brown, Photogramm. Eng. 37, 855 (1971)",
    gives_away="velocities change with the place in the frame, most far from its centre",
    confused_with=("perspective", "pixel-aspect", "image-scale", "drag"),
    appear=appear,
)
