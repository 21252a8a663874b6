"""A camera at a finite distance, and the mirror as the reflection that it is.

The pinhole looks along -Z; its axis meets the middle of the frame. Reflected in the mirror's plane
it becomes a second pinhole, which sees the spheres from above and from farther away.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulators.world.optics import Optics, front_view, top_view

Floats = NDArray[np.float64]

_INFINITY_M = 1.0e4


@dataclass(frozen=True, slots=True)
class Eye:
    """A pinhole.

    Parameters
    ----------
    place
        (3,) in m, rig axes.
    axes
        (3, 3); takes a rig vector to (row, column, toward the eye).
    focal_px
        Focal length.
    middle_px
        (row, column) where its axis meets the frame.
    """

    place: Floats
    axes: Floats
    focal_px: float
    middle_px: tuple[float, float]

    def centre_px(self, point: Floats) -> tuple[float, float]:
        """Return (row, column) of a point (3,) in m; integers are pixel centres."""
        row, column, toward = self.axes @ (point - self.place)
        return (
            self.middle_px[0] - self.focal_px * float(row / toward),
            self.middle_px[1] - self.focal_px * float(column / toward),
        )

    def rays(self, rows: Floats, columns: Floats) -> Floats:
        """Return unit vectors (rows, columns, 3) in rig axes from the eye through pixels."""
        down, across = np.meshgrid(
            rows - self.middle_px[0], columns - self.middle_px[1], indexing="ij"
        )
        seen = np.stack([down, across, np.full(down.shape, -self.focal_px)], axis=-1)
        return np.asarray(seen / np.linalg.norm(seen, axis=-1, keepdims=True)) @ self.axes


def eyes(optics: Optics) -> tuple[Eye, Eye]:
    """Return the eye itself and its image in the mirror.

    The origin appears at `front_origin_px` and `top_origin_px`, as it does from infinity.
    """
    distance = optics.distance_m or _INFINITY_M
    focal = optics.scale_px_per_m * distance
    middle = ((optics.rows - 1) / 2.0, (optics.columns - 1) / 2.0)
    if optics.distance_m is None:
        middle = optics.front_origin_px
    place = np.array(
        [
            (middle[0] - optics.front_origin_px[0]) / optics.scale_px_per_m,
            (middle[1] - optics.front_origin_px[1]) / optics.scale_px_per_m,
            distance,
        ]
    )
    front = Eye(place, front_view(optics).axes, focal, middle)
    if optics.distance_m is None:
        # From infinity the mirror's height has no meaning; each view has its origin where stated.
        view = top_view(optics)
        return front, Eye(distance * view.axes[2], view.axes, focal, optics.top_origin_px)
    normal = np.array([np.cos(_angle(optics)), 0.0, np.sin(_angle(optics))])
    reach = -mirror_height_m(optics) * normal[0]
    reflected = place - 2.0 * (normal @ place - reach) * normal
    return front, Eye(reflected, top_view(optics).axes, focal, middle)


def mirror_height_m(optics: Optics) -> float:
    """Return how far above the origin the mirror's plane meets the X axis, m.

    So that the origin appears in the row of `top_origin_px`, for a mirror at 45 degrees.
    """
    if optics.distance_m is None:
        return _INFINITY_M
    middle = (optics.rows - 1) / 2.0
    focal = optics.scale_px_per_m * optics.distance_m
    lateral = (middle - optics.front_origin_px[0]) / optics.scale_px_per_m
    above = middle - optics.top_origin_px[0]
    return (above * optics.distance_m - focal * lateral) / (focal - above)


def _angle(optics: Optics) -> float:
    return np.pi / 4.0 + optics.mirror_rad


def seen_at(optics: Optics, point: Floats) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return (row, column) of a point (3,) in the direct view and in the mirror, pixels."""
    if optics.distance_m is None:
        scale = optics.scale_px_per_m
        front, top = front_view(optics), top_view(optics)
        return front.centre_px(point, scale), top.centre_px(point, scale)
    direct, mirrored = eyes(optics)
    return direct.centre_px(point), mirrored.centre_px(point)
