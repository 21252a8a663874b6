"""Where in the frame the two views show a point, in pixels from the frame's centre."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.imaging.views import View, ViewGeometry, view_geometries
from analysis.setup import CameraSetup


def frame_places(
    position: Floats, camera: CameraSetup, scale_px_per_m: float
) -> dict[View, Floats]:
    """Return (row, column) from the frame's centre of a point in each view.

    Parameters
    ----------
    position
        In rig axes, m, shape (..., 3).

    Returns
    -------
    By view, pixels, shape (..., 2).
    """
    return {
        geometry.view: _place(position, geometry, camera, scale_px_per_m)
        for geometry in view_geometries(camera)
    }


def _place(
    position: Floats, geometry: ViewGeometry, camera: CameraSetup, scale_px_per_m: float
) -> Floats:
    centre = np.array([(camera.height_px - 1) / 2, (camera.width_px - 1) / 2])
    offset = geometry.offsets(position)[..., :2]
    return np.asarray(geometry.origin + scale_px_per_m * offset - centre)
