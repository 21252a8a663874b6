"""The image of one marked sphere that a pinhole sees in the light of the scene, ray-cast."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulators.world.disc import SUBPIXELS
from simulators.world.lamp import Lamp
from simulators.world.optics import Lighting
from simulators.world.pinhole import Eye

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Scene:
    """What lights a sphere beside its view's own light.

    Parameters
    ----------
    lamp
        None: the view's light.
    others
        Centres (3,) in m and radii in m of the spheres that may stand in the lamp's way.
    mirror_m
        Height of the mirror's plane above the origin.
    """

    lamp: Lamp | None
    others: tuple[tuple[Floats, float], ...]
    mirror_m: float


@dataclass(frozen=True, slots=True)
class Ball:
    """A sphere as a pinhole sees it.

    Parameters
    ----------
    eye
        Which sees it, in pixels of the canvas.
    centre, radius_m
        (3,) in m and m, rig axes.
    markers
        Marker directions (number, 3), rig axes.
    marker_radius_rad, marker_reflectance
        Angular radius, and brightness relative to the surface.
    light
        Of the view.
    scene
        What lights it.
    """

    eye: Eye
    centre: Floats
    radius_m: float
    markers: Floats
    marker_radius_rad: float
    marker_reflectance: float
    light: Lighting
    scene: Scene

    @property
    def radius_px(self) -> float:
        """Radius of the outline, pixels."""
        away = float(np.linalg.norm(self._to_centre))
        return self.eye.focal_px * self.radius_m / math.sqrt(away**2 - self.radius_m**2)

    @property
    def first(self) -> tuple[int, int]:
        """First row and column of pixels the outline can touch."""
        row, column = self.eye.centre_px(self.centre)
        return math.floor(row - self.radius_px) - 2, math.floor(column - self.radius_px) - 2

    @property
    def last(self) -> tuple[int, int]:
        """One past the last row and column of pixels the outline can touch."""
        row, column = self.eye.centre_px(self.centre)
        return math.ceil(row + self.radius_px) + 3, math.ceil(column + self.radius_px) + 3

    def meets(self, shape: tuple[int, ...]) -> bool:
        """Return whether any of the sphere lies in a frame of this shape (rows, columns)."""
        return all(
            last > 0 and first < size
            for first, last, size in zip(self.first, self.last, shape, strict=True)
        )

    def paint(self, canvas: NDArray[np.float32], origin: tuple[int, int]) -> None:
        """Paint the sphere over a canvas of sub-pixels whose first pixel is `origin`.

        Edges are blended by the part of a sub-pixel that lies inside.
        """
        rows, down = self._axis(0, origin[0], canvas.shape[0])
        columns, across = self._axis(1, origin[1], canvas.shape[1])
        rays = self.eye.rays(rows, columns)
        steep = self.radius_px * SUBPIXELS
        beside = (rays @ self._to_centre)[..., None] * rays - self._to_centre
        rho = np.sqrt(np.einsum("rck,rck->rc", beside, beside)) / self.radius_m
        hit = rho < 1.0 + 1.0 / steep
        rays, beside, rho = rays[hit], beside[hit], rho[hit]
        height = np.sqrt(np.maximum(1.0 - rho**2, 0.0))
        normal = beside / (self.radius_m * np.maximum(rho, 1.0))[:, None] - height[:, None] * rays
        grey, gloss = self._lit(normal, -rays, height)
        inside = np.clip((1.0 - rho) * steep + 0.5, 0.0, 1.0)
        patch = canvas[down, across]
        seen = grey * self._unmarked(normal, steep) + gloss
        patch[hit] += (inside * (seen - patch[hit])).astype(np.float32)

    @property
    def _to_centre(self) -> Floats:
        return self.centre - self.eye.place

    def _axis(self, axis: int, origin: int, size: int) -> tuple[Floats, slice]:
        """Return where a canvas axis meets the outline: pixels, and the sub-pixels."""
        first = max((self.first[axis] - origin) * SUBPIXELS, 0)
        last = max(min((self.last[axis] - origin) * SUBPIXELS, size), first)
        pixels = (np.arange(first, last) + 0.5) / SUBPIXELS - 0.5 + origin
        return pixels, slice(first, last)

    def _lit(self, normal: Floats, eye: Floats, height: Floats) -> tuple[Floats, Floats]:
        """Return the light of the bare surface and its gloss, grey levels."""
        lamp = self.scene.lamp
        if lamp is None:
            own, seen = self.light, normal @ self.eye.axes.T
            side = own.side_light * (own.side_row * seen[..., 0] + own.side_column * seen[..., 1])
            limb = 1.0 - own.limb_darkening * (1.0 - height)
            return own.brightness * (1.0 + side) * limb, np.zeros(height.shape)
        points = self.centre + self.radius_m * normal
        matt, gloss = np.zeros(height.shape), np.zeros(height.shape)
        for own_lamp in lamp.all:
            lit = own_lamp.seen_past_mirror(points, self.scene.mirror_m)
            for centre, radius_m in self.scene.others:
                lit *= own_lamp.seen_past(points, centre, radius_m)
            even = 1.0 + points @ np.array(own_lamp.uneven_per_m)
            swallowed, above = own_lamp.grey(normal, eye, lit)
            matt, gloss = matt + even * swallowed, gloss + even * above
        return matt, gloss

    def _unmarked(self, normal: Floats, steep: float) -> Floats:
        """Return what the markers leave of the light: caps with soft rims, none on another."""
        if not len(self.markers):
            return np.ones(len(normal))
        sine, cosine = math.sin(self.marker_radius_rad), math.cos(self.marker_radius_rad)
        facing = (normal @ self.markers.T).max(axis=1)
        cover = np.clip((facing - cosine) / sine * steep + 0.5, 0.0, 1.0)
        return np.asarray(1.0 - (1.0 - self.marker_reflectance) * cover)
