"""Where a sphere appears in each view, and how its image moves with it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import compiled
from analysis.imaging.views import View, view_geometries
from analysis.setup import CameraSetup

Floats = NDArray[np.float64]


class Optics(NamedTuple):
    """The views of a camera as compiled functions take them, V of them, the front view first.

    Attributes
    ----------
    axes
        Directions of increasing row, increasing column, and towards the eye, shape (V, 3, 3).
    origins
        Row and column of the rig's origin, pixels, shape (V, 2).
    scales
        Pixels per metre, shape (V,).
    hands
        1 where those axes are right-handed, -1 in a mirror, shape (V,).
    rows
        Half-open range of rows that may show the view, shape (V, 2).
    """

    axes: Floats
    origins: Floats
    scales: Floats
    hands: Floats
    rows: NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """The views of a camera with what has been measured of them."""

    views: tuple[View, ...]
    optics: Optics

    def with_scales(self, scales: Floats) -> Camera:
        """Return the camera with other scales, px/m, shape (V,)."""
        return replace(self, optics=self.optics._replace(scales=scales))

    def with_origins(self, origins: Floats) -> Camera:
        """Return the camera with the rig's origin at other pixels, shape (V, 2)."""
        return replace(self, optics=self.optics._replace(origins=origins))


def camera_of(setup: CameraSetup, scales: Floats) -> Camera:
    """Return the camera of a set-up, orthographic, with the scale of each view in px/m.

    The front view may reach into the rows of the top view: a sphere stands before the mirror.
    """
    views = view_geometries(setup)
    axes = np.stack([geometry.offsets(np.eye(3)).T for geometry in views])
    rows = [(0, setup.height_px)] + [geometry.rows for geometry in views[1:]]
    optics = Optics(
        axes=np.ascontiguousarray(axes),
        origins=np.array([geometry.origin for geometry in views], dtype=np.float64),
        scales=np.asarray(scales, dtype=np.float64),
        hands=np.sign(np.linalg.det(axes)),
        rows=np.array(rows, dtype=np.int64),
    )
    return Camera(tuple(geometry.view for geometry in views), optics)


@compiled
def disc_of(
    optics: Optics, view: int, centre: Floats, radius_m: float
) -> tuple[float, float, float]:
    """Return row, column and radius of a sphere's disc, pixels."""
    axes, scale = optics.axes[view], optics.scales[view]
    row = optics.origins[view, 0]
    column = optics.origins[view, 1]
    for k in range(3):
        row += scale * axes[0, k] * centre[k]
        column += scale * axes[1, k] * centre[k]
    return row, column, scale * radius_m
