"""Pictures of marked spheres, front view and mirror view in one frame.

Each sphere is ray-cast on a grid of sub-pixels about its own image; the frame is the box average
of the sub-pixels, blurred by the lens, averaged over the exposure, with read noise, rounded to
8 bit. Orthographic, as the thesis assumes, unless the optics have a distance or a lamp.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from simulators.world.ball import Ball, Scene
from simulators.world.description import Sphere
from simulators.world.disc import SUBPIXELS, Disc
from simulators.world.optics import Optics, front_view, picture_rows, top_view
from simulators.world.pinhole import Eye, eyes, mirror_height_m
from simulators.world.rotation import matrix
from simulators.world.state import Pose

# The lens spreads light from just outside the frame into it.
_MARGIN = 4
_SMEAR_PER_POSE_PX = 0.35
FLICKER_HZ = 100.0
_BLOTCH_PX = 2.0
_WALL = 7
"""Seed of the one wall there is: it stands still from shot to shot."""


Poses = Callable[[float], Sequence[Pose | None]]


class Camera:
    """Takes pictures of spheres whose poses are known at any time.

    Parameters
    ----------
    optics
        Camera, mirror and light.
    spheres
        The two spheres.
    markers
        Their marker directions, (number, 3) unit vectors in body axes each.
    """

    def __init__(
        self,
        optics: Optics,
        spheres: Sequence[Sphere],
        markers: Sequence[NDArray[np.float64]],
    ) -> None:
        self.optics = optics
        self._spheres = tuple(spheres)
        self.markers = tuple(markers)
        self._front, self._top = front_view(optics), top_view(optics)
        self._eyes = tuple(_within_margin(eye) for eye in eyes(optics))
        self._background = _background(optics)

    def expose(self, poses: Poses, time_s: float, rows: int | None = None) -> NDArray[np.float32]:
        """Return the light on the sensor as grey levels (rows, columns), without noise.

        The exposure is centred on `time_s`. Fewer rows than a full frame are those about its
        middle (`picture_rows`).
        """
        first, last = picture_rows(self.optics, rows)
        times = self._instants(poses, time_s)
        light = np.zeros_like(self._background)
        for time in times:
            light += self._instant(poses(time))
        light *= np.float32(self._lamps(time_s) / len(times))
        seen = through_lens(self.optics, self.optics.sensor.reached(light))
        whole = seen[_MARGIN + first : _MARGIN + last, _MARGIN:-_MARGIN]
        return self.optics.sensor.grey(whole)

    def take(
        self,
        poses: Poses,
        time_s: float,
        rng: np.random.Generator,
        rows: int | None = None,
    ) -> NDArray[np.uint8]:
        """Return the picture (rows, columns) with read noise, rounded and clipped to 8 bit."""
        grey, sensor = self.expose(poses, time_s, rows), self.optics.sensor
        seen = digitised(grey, sensor.noise_grey(grey, self.optics.noise_grey), rng)
        return sensor.read(seen, picture_rows(self.optics, rows)[0])

    def _lamps(self, time_s: float) -> float:
        """Return the brightness of the lamps, 1 in the mean."""
        return 1.0 + self.optics.flicker * math.sin(2.0 * math.pi * FLICKER_HZ * time_s)

    def _instants(self, poses: Poses, time_s: float) -> list[float]:
        """Spread instants over the exposure, so that no image moves far between two."""
        half = self.optics.exposure_s / 2.0
        way_m = 0.0
        ends = zip(poses(time_s - half), poses(time_s + half), self._spheres, strict=True)
        for before, after, sphere in ends:
            if before is not None and after is not None:
                turned = 2.0 * float(np.linalg.norm(after.orientation - before.orientation))
                moved = float(np.linalg.norm(after.centre - before.centre))
                way_m = max(way_m, moved + turned * sphere.radius_m)
        number = max(1, math.ceil(way_m * self.optics.scale_px_per_m / _SMEAR_PER_POSE_PX))
        # Midpoints of equal parts: in uniform motion their mean is the pose at mid-exposure.
        return [time_s + half * ((2 * k + 1) / number - 1.0) for k in range(number)]

    def _instant(self, poses: Sequence[Pose | None]) -> NDArray[np.float32]:
        """Return the scene at one instant, in pixels with a margin, before the lens."""
        frame = self._background.copy()
        discs = [disc for disc in self._images(poses) if disc.meets(frame.shape)]
        if not discs:
            return frame
        rows = slice(
            max(min(disc.first[0] for disc in discs), 0),
            min(max(disc.last[0] for disc in discs), frame.shape[0]),
        )
        columns = slice(
            max(min(disc.first[1] for disc in discs), 0),
            min(max(disc.last[1] for disc in discs), frame.shape[1]),
        )
        area = frame[rows, columns]
        size = (area.shape[1], area.shape[0])
        canvas: NDArray[np.float32] = np.asarray(
            cv2.resize(
                area, (size[0] * SUBPIXELS, size[1] * SUBPIXELS), interpolation=cv2.INTER_NEAREST
            ),
            dtype=np.float32,
        )
        for disc in discs:
            disc.paint(canvas, (rows.start, columns.start))
        frame[rows, columns] = cv2.resize(canvas, size, interpolation=cv2.INTER_AREA)
        return frame

    def _images(self, poses: Sequence[Pose | None]) -> Sequence[Disc | Ball]:
        """Return the images of the spheres in the order of painting, hidden ones first."""
        plain = self.optics.distance_m is None and self.optics.lamp is None
        return self._discs(poses) if plain else self._balls(poses)

    def _balls(self, poses: Sequence[Pose | None]) -> list[Ball]:
        """Return the images that a pinhole or a lamp makes."""
        there = [
            (pose, sphere, markers)
            for pose, sphere, markers in zip(poses, self._spheres, self.markers, strict=True)
            if pose is not None
        ]
        balls = []
        for eye, view in zip(self._eyes[::-1], (self._top, self._front), strict=True):
            for pose, sphere, markers in sorted(
                there, key=lambda item: -float(np.linalg.norm(item[0].centre - eye.place))
            ):
                others = tuple((p.centre, s.radius_m) for p, s, _ in there if p is not pose)
                height = mirror_height_m(self.optics)
                balls.append(
                    Ball(
                        eye=eye,
                        centre=pose.centre,
                        radius_m=sphere.radius_m,
                        markers=markers @ matrix(pose.orientation).T,
                        marker_radius_rad=sphere.marker_radius_rad,
                        marker_reflectance=sphere.marker_reflectance,
                        light=view.light,
                        scene=Scene(self.optics.lamp, others, height),
                    )
                )
        return balls

    def _discs(self, poses: Sequence[Pose | None]) -> list[Disc]:
        """Return the images of the spheres in the order of painting, hidden ones first.

        In the mirror the higher sphere hides the lower one, in the direct view the nearer the
        farther; and the direct view covers the mirror, which stands behind the spheres.
        """
        seen = [
            (pose, sphere, markers)
            for pose, sphere, markers in zip(poses, self._spheres, self.markers, strict=True)
            if pose is not None
        ]
        discs = []
        for view in (self._top, self._front):
            for pose, sphere, markers in sorted(
                seen, key=lambda item: float(view.axes[2] @ item[0].centre)
            ):
                row, column = view.centre_px(pose.centre, self.optics.scale_px_per_m)
                discs.append(
                    Disc(
                        centre=(row + _MARGIN, column + _MARGIN),
                        radius=sphere.radius_m * self.optics.scale_px_per_m,
                        markers=markers @ (view.axes @ matrix(pose.orientation)).T,
                        marker_radius_rad=sphere.marker_radius_rad,
                        marker_reflectance=sphere.marker_reflectance,
                        light=view.light,
                    )
                )
        return discs


def _within_margin(eye: Eye) -> Eye:
    """Return an eye in pixels of a frame with the margin about it."""
    row, column = eye.middle_px
    return replace(eye, middle_px=(row + _MARGIN, column + _MARGIN))


def through_lens(optics: Optics, light: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return light (rows, columns) as the lens spreads it."""
    if optics.defocus_px > 0.0:
        light = np.asarray(cv2.filter2D(light, -1, _even_disc(optics.defocus_px)), np.float32)
    blur = optics.blur_px
    seen = cv2.GaussianBlur(light, (0, 0), blur) if blur > 0.0 else light
    return np.asarray(seen, dtype=np.float32)


def _even_disc(radius_px: float) -> NDArray[np.float32]:
    """Return the share of a disc's area in each pixel about its centre, by sub-pixels."""
    half = math.ceil(radius_px)
    fine = (np.arange((2 * half + 1) * SUBPIXELS) + 0.5) / SUBPIXELS - half - 0.5
    within = (np.hypot(fine[:, None], fine) <= radius_px).astype(np.float32)
    shares = cv2.resize(within, (2 * half + 1,) * 2, interpolation=cv2.INTER_AREA)
    return np.asarray(shares / shares.sum(), dtype=np.float32)


def digitised(
    light: NDArray[np.float32], noise_grey: float | NDArray[np.float32], rng: np.random.Generator
) -> NDArray[np.uint8]:
    """Return light (rows, columns) as a picture: with noise, rounded, clipped to 8 bit."""
    noise = rng.standard_normal(light.shape, dtype=np.float32)
    grey = light + np.asarray(noise_grey, dtype=np.float32) * noise
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


def _background(optics: Optics) -> NDArray[np.float32]:
    rows = np.arange(-_MARGIN, optics.rows + _MARGIN)[:, None]
    columns = np.arange(-_MARGIN, optics.columns + _MARGIN)[None, :]
    plane = optics.background + optics.background_per_row * rows
    plane = plane + optics.background_per_column * columns
    if optics.texture_grey > 0.0:
        blotches = np.random.default_rng(_WALL).standard_normal(plane.shape)
        soft = cv2.GaussianBlur(blotches, (0, 0), _BLOTCH_PX)
        plane = np.maximum(plane + optics.texture_grey / soft.std() * soft, 0.0)
    return np.asarray(plane, dtype=np.float32)
