"""The image of one marked sphere, ray-cast on sub-pixels."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulators.world.optics import Lighting

SUBPIXELS = 6
"""Sub-pixels along a pixel's side."""

# In radii: wider than the soft edge of a marker.
_EDGE = 0.02


@dataclass(frozen=True, slots=True)
class Disc:
    """A sphere as one view shows it.

    Parameters
    ----------
    centre
        (row, column) in pixels; integers are pixel centres.
    radius
        In pixels.
    markers
        Marker directions (number, 3) as (row, column, toward the viewer).
    marker_radius_rad, marker_reflectance
        Angular radius, and brightness relative to the surface.
    light
        How the surface is lit in this view.
    """

    centre: tuple[float, float]
    radius: float
    markers: NDArray[np.float64]
    marker_radius_rad: float
    marker_reflectance: float
    light: Lighting

    @property
    def first(self) -> tuple[int, int]:
        """First row and column of pixels the disc can touch."""
        return (
            math.floor(self.centre[0] - self.radius) - 1,
            math.floor(self.centre[1] - self.radius) - 1,
        )

    @property
    def last(self) -> tuple[int, int]:
        """One past the last row and column of pixels the disc can touch."""
        return (
            math.ceil(self.centre[0] + self.radius) + 2,
            math.ceil(self.centre[1] + self.radius) + 2,
        )

    def meets(self, shape: tuple[int, ...]) -> bool:
        """Return whether any of the disc lies in a frame of this shape (rows, columns)."""
        return all(
            last > 0 and first < size
            for first, last, size in zip(self.first, self.last, shape, strict=True)
        )

    def paint(self, canvas: NDArray[np.float32], origin: tuple[int, int]) -> None:
        """Paint the disc over a canvas of sub-pixels whose first pixel is `origin`.

        Edges are blended by the part of a sub-pixel that lies inside.
        """
        y, rows = self._axis(0, origin[0], canvas.shape[0])
        x, columns = self._axis(1, origin[1], canvas.shape[1])
        square = y[:, None] ** 2 + x[None, :] ** 2
        height = np.sqrt(np.maximum(1.0 - square, 0.0))
        inside = self._soft(1.0 - np.sqrt(square))
        light = self.light
        side = light.side_light * (light.side_row * y[:, None] + light.side_column * x[None, :])
        grey = (1.0 + side) * (1.0 - light.limb_darkening * (1.0 - height)) * light.brightness
        for marker in self.markers:
            self._darken(grey, y, x, height, marker)
        patch = canvas[rows, columns]
        patch += inside * (grey - patch)

    def _axis(self, axis: int, origin: int, size: int) -> tuple[NDArray[np.float32], slice]:
        """Return where a canvas axis meets the disc: positions in radii, and the sub-pixels."""
        first = max((self.first[axis] - origin) * SUBPIXELS, 0)
        last = max(min((self.last[axis] - origin) * SUBPIXELS, size), first)
        pixel = (np.arange(first, last) + 0.5) / SUBPIXELS - 0.5 + origin
        return ((pixel - self.centre[axis]) / self.radius).astype(np.float32), slice(first, last)

    def _soft(self, margin: NDArray[np.float32]) -> NDArray[np.float32]:
        """Turn a distance inside an edge, in radii, into the part of a sub-pixel inside."""
        steep = margin * np.float32(self.radius * SUBPIXELS) + np.float32(0.5)
        return np.asarray(np.clip(steep, 0.0, 1.0), dtype=np.float32)

    def _darken(
        self,
        grey: NDArray[np.float32],
        y: NDArray[np.float32],
        x: NDArray[np.float32],
        height: NDArray[np.float32],
        marker: NDArray[np.float64],
    ) -> None:
        """Darken one marker: a cap about its direction, where that faces the viewer."""
        sine, cosine = math.sin(self.marker_radius_rad), math.cos(self.marker_radius_rad)
        if marker[2] <= -sine:
            return
        rows = _reach(y, float(marker[0]), self.marker_radius_rad)
        columns = _reach(x, float(marker[1]), self.marker_radius_rad)
        toward = marker.astype(np.float32)
        facing = y[rows, None] * toward[0] + x[None, columns] * toward[1]
        facing += height[rows, columns] * toward[2]
        cover = self._soft((facing - np.float32(cosine)) / np.float32(sine))
        grey[rows, columns] *= 1.0 - (1.0 - self.marker_reflectance) * cover


def _reach(axis: NDArray[np.float32], cosine: float, radius_rad: float) -> slice:
    """Return the sub-pixels of an axis that a cap can touch, given the cosine between the two."""
    angle = math.acos(max(-1.0, min(1.0, cosine)))
    low, high = min(angle + radius_rad, math.pi), max(angle - radius_rad, 0.0)
    first, last = np.searchsorted(axis, [math.cos(low) - _EDGE, math.cos(high) + _EDGE])
    return slice(int(first), int(last))
