"""A disk with five dark markers on a motor's shaft, seen square on (thesis, chapter 6)."""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from simulators.world.render import digitised

RATE_RPM, FRAME_RATE_HZ, FRAMES = 997.0, 1000.0, 15
EXPOSURE_S = 1.0e-4
ROWS, COLUMNS = 192, 240
CENTRE_PX = (96.0, 120.0)
DISK_RADIUS_PX, MARKER_RADIUS_PX = 84.0, 5.0
MARKERS = ((62.0, 0.30), (50.0, 1.62), (66.0, 2.75), (40.0, 4.05), (58.0, 5.20))
"""Distance from the axis, pixels, and angle at rest, radians, of each marker."""
SURROUNDINGS, DISK, MARKER_REFLECTANCE = 33.0, 150.0, 0.3
LIGHT_SLOPE_PER_PX = (4.0e-4, -6.0e-4)
"""Relative, along rows and columns."""
BLUR_PX, NOISE_GREY = 0.8, 1.5
_SUBPIXELS, _INSTANTS = 6, 5


class TurningDisk(NamedTuple):
    """Frames (N, rows, columns) at times (N,) in s, and the turn from frame to frame, radians."""

    frames: NDArray[np.uint8]
    times_s: NDArray[np.float64]
    turn_rad: float


class Disk(NamedTuple):
    """The disk before its camera: bare light, axis (row, column), angle at zero, rate in rad/s."""

    bare: NDArray[np.float32]
    centre: NDArray[np.float64]
    start_rad: float
    rate_rad_per_s: float
    exposure_s: float

    def take(self, time_s: float, rng: np.random.Generator) -> NDArray[np.uint8]:
        """Return the picture (rows, columns) with mid-exposure at a time."""
        rate = self.rate_rad_per_s
        angle, swept = self.start_rad + rate * time_s, rate * self.exposure_s
        return digitised(_exposed(self.bare, self.centre, angle, swept), NOISE_GREY, rng)


def filmed_disk(
    rng: np.random.Generator, rate_rpm: float = RATE_RPM, exposure_s: float = EXPOSURE_S
) -> Disk:
    """Put up the disk, its axis and its angle where chance says."""
    start = rng.uniform(0.0, 2.0 * math.pi)
    centre = np.array(CENTRE_PX) + rng.uniform(-0.5, 0.5, 2)
    return Disk(_bare(centre), centre, start, rate_rpm / 60.0 * 2.0 * math.pi, exposure_s)


def turning_disk(seed: int) -> TurningDisk:
    """Film the disk at the thesis's 997 turns a minute and 1000 frames a second."""
    rng = np.random.default_rng([seed, 2])
    disk = filmed_disk(rng)
    times = np.arange(FRAMES) / FRAME_RATE_HZ
    frames = [disk.take(time, rng) for time in times.tolist()]
    return TurningDisk(np.stack(frames), times, disk.rate_rad_per_s / FRAME_RATE_HZ)


def _bare(centre: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return the light of the disk without markers, before the lens."""
    rows, columns = np.indices((ROWS, COLUMNS)).astype(np.float32)
    slopes = LIGHT_SLOPE_PER_PX
    lit = 1.0 + slopes[0] * (rows - CENTRE_PX[0]) + slopes[1] * (columns - CENTRE_PX[1])
    on_disk = _cover(float(centre[0]), float(centre[1]), DISK_RADIUS_PX)
    return np.asarray(lit * (SURROUNDINGS + (DISK - SURROUNDINGS) * on_disk), dtype=np.float32)


def _exposed(
    bare: NDArray[np.float32], centre: NDArray[np.float64], angle: float, swept: float
) -> NDArray[np.float32]:
    """Return the light of a frame, the mean over the exposure, through the lens."""
    light = np.zeros_like(bare)
    for k in range(_INSTANTS):
        light += _marked(bare, centre, angle + swept * ((k + 0.5) / _INSTANTS - 0.5))
    seen = cv2.GaussianBlur(light / _INSTANTS, (0, 0), BLUR_PX, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(seen, dtype=np.float32)


def _marked(
    bare: NDArray[np.float32], centre: NDArray[np.float64], angle: float
) -> NDArray[np.float32]:
    light = bare.copy()
    for distance, own in MARKERS:
        # From the row axis towards the column axis.
        row = float(centre[0]) + distance * math.cos(own + angle)
        column = float(centre[1]) + distance * math.sin(own + angle)
        light *= 1.0 - (1.0 - MARKER_REFLECTANCE) * _cover(row, column, MARKER_RADIUS_PX)
    return light


def _cover(row: float, column: float, radius: float) -> NDArray[np.float32]:
    """Return the part of each pixel inside a circle, by sub-pixels with blended edges."""
    cover = np.zeros((ROWS, COLUMNS), dtype=np.float32)
    first = (math.floor(row - radius) - 1, math.floor(column - radius) - 1)
    size = 2 * math.ceil(radius) + 4
    fine = (np.arange(size * _SUBPIXELS) + 0.5) / _SUBPIXELS - 0.5
    distance = np.hypot((first[0] + fine - row)[:, None], (first[1] + fine - column)[None, :])
    inside = np.clip((radius - distance) * _SUBPIXELS + 0.5, 0.0, 1.0)
    blocks = inside.reshape(size, _SUBPIXELS, size, _SUBPIXELS).mean(axis=(1, 3))
    top, left = max(first[0], 0), max(first[1], 0)
    bottom, right = min(first[0] + size, ROWS), min(first[1] + size, COLUMNS)
    cover[top:bottom, left:right] = blocks[
        top - first[0] : bottom - first[0], left - first[1] : right - first[1]
    ]
    return cover
