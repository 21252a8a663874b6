"""Edge points on the gradient's ridges, of all channels of a picture."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Singles
from analysis.compiled import compiled, part

SIGMA_PX = 1.2
NOISE_QUANTILE = 0.3
LEAST_OF_NOISE = 2.5
"""An edge is stronger than so many Rayleigh scales of what is no edge."""
STRONG_QUANTILE = 0.998
LEAST_OF_STRONG = 0.02
"""An edge has this share at least of the picture's strongest ones."""
_RAYLEIGH = math.sqrt(-2.0 * math.log(1.0 - NOISE_QUANTILE))
"""This quantile of a Rayleigh distribution with scale 1."""
PATCH_PX, LEAST_PATCHES, STRONG_QUANTILE_OF_PATCH, MOST_LIFT = 32, 3, 0.98, 4.0
"""Side of the patches that have a least size of an edge of their own, how many there are at least
along each side, which of their sizes is a strong one, and how much smaller an edge may be."""

CHANGE_PX, CALMER_ROUNDS, LEAST_EVENED_PX = 3, 4, 24
"""Pixels over which a ground's changes of colour are seen, as noise of single pixels is none; how
often its calmer half is chosen anew; and the smallest picture that shows a ground."""
LEAST_SPREAD = 1e-3
"""Of the largest variance of a ground's changes: what a grey picture lacks is no colour."""


@dataclass(frozen=True, slots=True, eq=False)
class Gradient:
    """Gradient of a picture.

    Attributes
    ----------
    field
        Length, in units of the picture's values per pixel, and unit direction (row, column)
        towards where the channels together are brighter; shape (3, rows, columns).
    edges
        Points on ridges above the threshold, shape (N, 4): row, column (subpixel), direction.
    threshold
        Least size of an edge.
    """

    field: Singles
    edges: Singles
    threshold: float


def gradient(picture: Singles, sigma_px: float = SIGMA_PX, *, local: bool = False) -> Gradient:
    """Return the gradient of a picture.

    The direction in which the channels together change most (Di Zenzo, 1986) needs no choice of a
    channel: a green ball on a red ground of the same brightness has a rim too.

    Parameters
    ----------
    picture
        Shape (rows, columns, channels), any unit.
    local
        Whether sizes are lifted where the picture is calmer than elsewhere (`_lift`).
    """
    down, right = derivatives(picture, sigma_px)
    if not local:
        return gradient_of(down, right)
    field = np.asarray(_tensor(down, right))
    threshold = edge_threshold(field[0])
    field[0] *= _lift(field[0], threshold)
    return Gradient(field, _ridges(field, threshold), threshold)


def gradient_of(down: Singles, right: Singles) -> Gradient:
    """Return the gradient of a picture from its `derivatives`."""
    field = np.asarray(_tensor(down, right))
    threshold = edge_threshold(field[0])
    return Gradient(field, _ridges(field, threshold), threshold)


def _lift(size: Singles, threshold: float) -> Singles | float:
    """Return by how much sizes count for more, place by place, as the neighbourhood is calmer.

    What is an edge beside bright clutter hides the rim of a dark ball on a dark cloth: in each
    patch the least size is that of the patch and those next to it, where this is less.
    """
    rows, columns = (side // PATCH_PX for side in size.shape)
    if min(rows, columns) < LEAST_PATCHES:
        return 1.0
    some = size[: rows * PATCH_PX : 2, : columns * PATCH_PX : 2]
    half = PATCH_PX // 2
    patches = some.reshape(rows, half, columns, half).swapaxes(1, 2).reshape(rows, columns, -1)
    count = patches.shape[2]
    ranks = [int(NOISE_QUANTILE * count), int(STRONG_QUANTILE_OF_PATCH * count)]
    ordered = np.partition(patches, ranks, axis=2)
    noise, strong = (np.ascontiguousarray(ordered[:, :, rank]) for rank in ranks)
    calm = np.asarray(cv2.blur(noise, (3, 3)), np.float32) / _RAYLEIGH
    steep = np.asarray(cv2.dilate(strong, np.ones((3, 3), np.uint8)), np.float32)
    least = np.maximum(LEAST_OF_NOISE * calm, LEAST_OF_STRONG * steep) / threshold
    lift = 1.0 / np.clip(least, 1.0 / MOST_LIFT, 1.0)
    return np.asarray(cv2.resize(lift.astype(np.float32), size.shape[::-1]), np.float32)


def edge_threshold(size: Singles) -> float:
    """Return the least size of an edge, from the sizes of a picture's gradients."""
    noise = float(np.quantile(size, NOISE_QUANTILE)) / _RAYLEIGH
    strong = float(np.quantile(size, STRONG_QUANTILE))
    return max(LEAST_OF_NOISE * noise, LEAST_OF_STRONG * strong, 1e-9)


def evened(picture: Singles) -> Singles:
    """Return a picture in colours that its ground changes more evenly.

    Light, shade and grain of a ground change all channels together and hide the rim of a ball that
    is as bright and of another hue. With C the covariance of the changes of the picture's calmer
    half, its colours are multiplied by C^(-1/4): halfway to colours in which the ground changes
    equally (C^(-1/2)), as a ball of the ground's own hue shows by its brightness alone.

    Parameters
    ----------
    picture
        Shape (rows, columns, channels), any unit. One of a single channel is returned as it is.
    """
    rows, columns, channels = picture.shape
    if channels == 1 or min(rows, columns) < LEAST_EVENED_PX:
        return picture
    size = (columns // CHANGE_PX, rows // CHANGE_PX)
    small = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.float64)
    changes = np.concatenate([np.diff(small, axis=k).reshape(-1, channels) for k in (0, 1)])
    calm = changes
    for _ in range(CALMER_ROUNDS):
        spread, axes = _spread(calm)
        if not spread.any():
            return picture
        far = ((changes @ (axes / np.sqrt(spread))) ** 2).sum(axis=1)
        calm = changes[far <= np.median(far)]
    spread, axes = _spread(calm)
    if not spread.any():
        return picture
    colours = (axes * spread**-0.25) @ axes.T
    return np.ascontiguousarray(picture @ colours.astype(np.float32))


def _spread(changes: Floats) -> tuple[Floats, Floats]:
    """Return the variances of changes along their main axes, and the axes as columns."""
    spread, axes = np.linalg.eigh(changes.T @ changes / len(changes))
    return np.maximum(spread, LEAST_SPREAD * spread.max()), axes


def gradient_field(picture: Singles, sigma_px: float) -> Singles:
    """Return size and direction (row, column) of the gradient, shape (3, rows, columns)."""
    return np.asarray(_tensor(*derivatives(picture, sigma_px)))


def derivatives(picture: Singles, sigma_px: float) -> tuple[Singles, Singles]:
    """Return the changes along rows and columns, shape (rows, columns, channels) each."""
    reach = math.ceil(3.5 * sigma_px)
    at = np.arange(-reach, reach + 1)
    smooth = np.exp(-0.5 * (at / sigma_px) ** 2)
    smooth = smooth / smooth.sum()
    change = at * smooth
    change = change / (at * change).sum()
    border = cv2.BORDER_REPLICATE
    kernels = [(smooth, change), (change, smooth)]
    found = [
        cv2.sepFilter2D(picture, cv2.CV_32F, across, down, borderType=border)
        for across, down in kernels
    ]
    down, across = (np.ascontiguousarray(np.atleast_3d(part), np.float32) for part in found)
    return down, across


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """Changes of a picture that is smaller by a factor.

    Attributes
    ----------
    down, right
        Along rows and columns, shape (rows, columns, channels) each.
    spread
        Covariance of the changes where the picture is calm, shape (channels, channels).
    """

    factor: float
    down: Singles
    right: Singles
    spread: Floats


def ground_of(picture: Singles, factor: float) -> Ground:
    """Return the changes of a picture, of shape (rows, columns, channels), made smaller."""
    small = picture
    if factor > 1.0:
        size = tuple(max(8, round(side / factor)) for side in picture.shape[1::-1])
        small = np.atleast_3d(cv2.resize(picture, size, interpolation=cv2.INTER_AREA))
    down, right = derivatives(np.ascontiguousarray(small), SIGMA_PX)
    size_of = np.sqrt((down**2 + right**2).sum(axis=2))
    calm = size_of < edge_threshold(_tensor(down, right)[0])
    changes = np.concatenate([down[calm], right[calm]]).astype(np.float64)
    spread = changes.T @ changes / max(1, len(changes))
    spread += (1e-3 * np.trace(spread) + 1e-12) * np.eye(len(spread)) / len(spread)
    return Ground(factor, down, right, spread)


@compiled
def _tensor(
    along_row: NDArray[np.float32], along_column: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Return size and direction of the structure tensor's first axis."""
    rows, columns, channels = along_row.shape
    field = np.empty((3, rows, columns), np.float32)
    size, row, column = field[0], field[1], field[2]
    for i in range(rows):
        for j in range(columns):
            a = b = c = 0.0
            sum_row = sum_column = 0.0
            for k in range(channels):
                p, q = along_row[i, j, k], along_column[i, j, k]
                a += p * p
                b += p * q
                c += q * q
                sum_row += p
                sum_column += q
            if channels == 1:
                length = math.sqrt(a + c)
                size[i, j] = length
                if length > 0.0:
                    row[i, j], column[i, j] = sum_row / length, sum_column / length
                else:
                    row[i, j], column[i, j] = 1.0, 0.0
                continue
            half = 0.5 * (a - c)
            size[i, j] = math.sqrt(0.5 * (a + c) + math.sqrt(half * half + b * b))
            angle = 0.5 * math.atan2(2.0 * b, a - c)
            u, v = math.cos(angle), math.sin(angle)
            if u * sum_row + v * sum_column < 0.0:
                u, v = -u, -v
            row[i, j], column[i, j] = u, v
    return field


@compiled
def _ridges(field: NDArray[np.float32], threshold: float) -> NDArray[np.float32]:
    """Return edge points where the size is largest along the direction, to a part of a pixel."""
    size, row, column = field[0], field[1], field[2]
    rows, columns = size.shape
    points = np.empty((rows * columns // 2 + 1, 4), np.float32)
    count = 0
    for i in range(1, rows - 1):
        for j in range(1, columns - 1):
            here = size[i, j]
            if here < threshold:
                continue
            u, v = row[i, j], column[i, j]
            # One pixel on along the larger component, and beside it.
            if abs(u) > abs(v):
                tilt = v / u
                side = 1 if tilt > 0 else -1
                w = abs(tilt)
                ahead = (1 - w) * size[i + 1, j] + w * size[i + 1, j + side]
                behind = (1 - w) * size[i - 1, j] + w * size[i - 1, j - side]
                step_row, step_column = 1.0, tilt
            else:
                tilt = u / v
                side = 1 if tilt > 0 else -1
                w = abs(tilt)
                ahead = (1 - w) * size[i, j + 1] + w * size[i + side, j + 1]
                behind = (1 - w) * size[i, j - 1] + w * size[i - side, j - 1]
                step_row, step_column = tilt, 1.0
            if here <= ahead or here < behind or count >= len(points):
                continue
            curve = ahead - 2.0 * here + behind
            shift = 0.5 * (behind - ahead) / curve if curve < 0.0 else 0.0
            shift = min(0.5, max(-0.5, shift))
            points[count, 0] = i + shift * step_row
            points[count, 1] = j + shift * step_column
            points[count, 2], points[count, 3] = u, v
            count += 1
    return points[:count].copy()


REACH_PX = 6.0
"""How much more of a picture than asked is about a circle, for the filters."""
WIDER = 1.6
"""Width of the filter, in that of the narrow one, whose edges tell how those shift, and how sharp a
rim is."""
EXACT_PX = 0.1
"""Error of an edge that does not shift with the width."""


def window_about(values: Singles, place: Floats, beyond: float) -> tuple[Singles, Floats]:
    """Return the picture about a circle, and its corner; `beyond` it in radii."""
    reach = math.ceil((1.0 + beyond) * place[2] + REACH_PX)
    top, left = (max(0, int(middle) - reach) for middle in place[:2])
    bottom, right = (int(middle) + reach + 1 for middle in place[:2])
    window = np.ascontiguousarray(values[top:bottom, left:right])
    return window, np.array([top, left, 0.0])


@part
def size_along(field: NDArray[np.float32], row: float, column: float, u: float, v: float) -> float:
    """Return the gradient's size in the direction (u, v), negative outside the picture."""
    _, rows, columns = field.shape
    i, j = int(row), int(column)
    if row < 0.0 or column < 0.0 or i + 1 >= rows or j + 1 >= columns:
        return -1.0
    p, q = row - i, column - j
    size = 0.0
    for di in range(2):
        for dj in range(2):
            weight = (p if di else 1.0 - p) * (q if dj else 1.0 - q)
            along = u * field[1, i + di, j + dj] + v * field[2, i + di, j + dj]
            size += weight * field[0, i + di, j + dj] * max(along, 0.0)
    return size
