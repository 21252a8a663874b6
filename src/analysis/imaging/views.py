"""Where the camera sees a point: the front view and the 45 degree mirror above (formats.md).

Rig axes: X down, Y right, Z toward the camera. Front: row = r0 + s X, column = c0 + s Y. Top, as
the mirror shows it: row = r0 - s Z, column = c0 + s Y, seen from smaller X.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from analysis.arrays import Floats
from analysis.setup import CameraSetup


class View(Enum):
    """The two views that share a frame."""

    FRONT = "front"
    TOP = "top"

    # Tables by view are read in every frame.
    __hash__ = object.__hash__


@dataclass(frozen=True, slots=True)
class ViewGeometry:
    """One view: its rows (half-open) and the pixel (row, column) of the rig's origin."""

    view: View
    rows: tuple[int, int]
    origin: tuple[float, float]

    def direction(self, row: Floats, column: Floats) -> Floats:
        """Lift points of a unit disc to the half of the unit sphere that the view shows.

        Equation (5-5) of the thesis, for either view.

        Parameters
        ----------
        row, column
            Offsets from the disc's centre in units of its radius, shape (points,).

        Returns
        -------
        Unit vectors in rig axes, shape (points, 3).
        """
        depth = np.sqrt(np.clip(1.0 - row**2 - column**2, 0.0, None))
        if self.view is View.FRONT:
            return np.stack([row, column, depth], axis=-1)
        return np.stack([-depth, column, -row], axis=-1)

    def offsets(self, direction: Floats) -> Floats:
        """Project unit vectors, shape (..., 3), to (row, column, depth), shape (..., 3).

        `depth` is towards the eye, positive where the view can see the point.
        """
        x, y, z = np.moveaxis(direction, -1, 0)
        parts = (x, y, z) if self.view is View.FRONT else (-z, y, -x)
        return np.stack(parts, axis=-1)


def view_geometries(camera: CameraSetup) -> tuple[ViewGeometry, ...]:
    """Return the views of a camera, the front view first."""
    views = [_geometry(View.FRONT, camera.front_view_rows, camera.front_origin_px, camera)]
    if camera.top_view_rows is not None:
        views.append(_geometry(View.TOP, camera.top_view_rows, camera.top_origin_px, camera))
    return tuple(views)


def _geometry(
    view: View, rows: tuple[int, int], origin: tuple[float, float] | None, camera: CameraSetup
) -> ViewGeometry:
    centre = ((rows[0] + rows[1] - 1) / 2, (camera.width_px - 1) / 2)
    return ViewGeometry(view, rows, origin if origin is not None else centre)
