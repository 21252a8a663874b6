"""The place of a ball in a frame: a smeared disc over the ground, fitted to every pixel's light.

Light of a pixel: F = B (1 - a) + a S, with the ground B, the share a of the exposure in which the
ball covers the pixel, and the ball's own light S: a smooth shading and what the film has taught.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import compiled, part

TERMS = 6
"""Of the smooth shading: 1, u, v, u v, u^2 - v^2, u^2 + v^2 in radii from the centre."""
STEP_PX, STEP_SIGMAS, MOST_STEP_RADII = 0.7, 1.75, 0.1
"""Of the ball along its smear: the more its rim is blurred, the longer they may be; finer steps
change a cover by less than 0.001."""
FURTHEST_SIGMAS = 4.0
MAP_STEPS = 24
"""Cells of the learned light from the centre to MAP_REACH radii."""
MAP_REACH = 1.25
MAP_SIDE = 2 * MAP_STEPS + 1
PASSES = 24
SETTLED_PX = 1e-3
UNKNOWNS = TERMS + 2
LIGHT = TERMS
LAYERS = TERMS + 1
"""What a ball covers and shows of each pixel: the terms, the first of which is the cover itself,
and the learned light."""
LARGEST_STEP_PX = 2.0
LEAST_COVER, LEAST_TAUGHT = 1e-4, 0.05
POSE, RADIUS, BLUR, STRETCH, WAY = 7, 2, 3, 4, 5
WINDOW, GROUND, WEIGHT, RESIDUAL = 4, 1, 2, 3
ROOT_HALF = math.sqrt(0.5)
INVERSE_ROOT_TWO_PI = 1.0 / math.sqrt(2.0 * math.pi)


@part
def _learned(table: NDArray[np.float64], u: float, v: float) -> float:
    """Return the learned light at a place in radii, bilinear."""
    i = (u / MAP_REACH + 1.0) * MAP_STEPS
    j = (v / MAP_REACH + 1.0) * MAP_STEPS
    p, q = int(i), int(j)
    if i < 0 or j < 0 or p >= MAP_SIDE - 1 or q >= MAP_SIDE - 1:
        return 0.0
    f, g = i - p, j - q
    low = (1 - g) * table[p, q] + g * table[p, q + 1]
    high = (1 - g) * table[p + 1, q] + g * table[p + 1, q + 1]
    return float((1 - f) * low + f * high)


@part
def _shading(u: float, v: float, terms: NDArray[np.float64]) -> None:
    terms[0] = 1.0
    terms[1] = u
    terms[2] = v
    terms[3] = u * v
    terms[4] = u * u - v * v
    terms[5] = u * u + v * v


@part
def _span(half: float, middle: float, most: int) -> tuple[int, int]:
    """Return the first pixel of a half-open range about a middle, and the one after its last."""
    return max(0, math.ceil(middle - half)), min(most, math.floor(middle + half) + 1)


@part
def _steps(pose: NDArray[np.float64]) -> int:
    """Return at how many instants of the exposure the ball is drawn."""
    step = max(STEP_PX, min(STEP_SIGMAS * pose[BLUR], MOST_STEP_RADII * pose[RADIUS]))
    return 1 + int(math.sqrt(pose[WAY] ** 2 + pose[WAY + 1] ** 2) / step)


@part
def _centre(pose: NDArray[np.float64], gone: float) -> tuple[float, float]:
    """Return row and column of the centre at a share of the exposure, -0.5 to 0.5."""
    return pose[0] + gone * pose[WAY], pose[1] + gone * pose[WAY + 1]


@compiled
def cover(
    pose: NDArray[np.float64], table: NDArray[np.float64], found: NDArray[np.float64]
) -> None:
    """Fill in what a ball on its way through an exposure covers and shows.

    Parameters
    ----------
    pose
        Row and column of the centre at the middle of the exposure; radius; blur; by how much a
        rolling shutter lengthens the ball along the rows; way of the centre during the exposure
        (row, column). Shape (POSE,).
    table
        Learned light.
    found
        Share of the exposure in which the ball covers each pixel, then each term of the shading and
        the learned light, averaged over the exposure while it does; shape (LAYERS, rows, columns).
    """
    radius, sigma, stretch = pose[RADIUS], pose[BLUR], pose[STRETCH]
    _, rows, columns = found.shape
    found[:] = 0.0
    terms = np.empty(TERMS)
    outer = radius + FURTHEST_SIGMAS * sigma
    steps = _steps(pose)
    for k in range(steps):
        row, column = _centre(pose, (k + 0.5) / steps - 0.5)
        top, bottom = _span(outer * stretch, row, rows)
        for i in range(top, bottom):
            dr = (i - row) / stretch
            left, right = _span(math.sqrt(max(outer * outer - dr * dr, 0.0)), column, columns)
            for j in range(left, right):
                dc = j - column
                away = math.sqrt(dr * dr + dc * dc)
                at = (radius - away) / sigma
                share = 1.0 / steps
                if at < FURTHEST_SIGMAS:
                    share *= 0.5 * (1.0 + math.erf(at * ROOT_HALF))
                # Beyond the limb, in the blur, the light is that of the limb.
                limb = max(radius, away)
                u, v = dr / limb, dc / limb
                found[LIGHT, i, j] += share * _learned(table, u, v)
                _shading(u, v, terms)
                for m in range(TERMS):
                    found[m, i, j] += share * terms[m]


@compiled
def rim(
    pose: NDArray[np.float64],
    light: NDArray[np.float64],
    table: NDArray[np.float64],
    ground: NDArray[np.float64],
    found: NDArray[np.float64],
) -> None:
    """Fill in how light changes with the ball's row and column, by its rim alone.

    What its surface shows is not taken to move with it: gloss does not, and a print turns.

    Parameters
    ----------
    pose, table
        As `cover` has them.
    light
        Of the terms of the shading.
    ground
        Light of what stands still.
    found
        Shape (2, rows, columns).
    """
    radius, sigma, stretch = pose[RADIUS], pose[BLUR], pose[STRETCH]
    _, rows, columns = found.shape
    found[:] = 0.0
    terms = np.empty(TERMS)
    outer = radius + FURTHEST_SIGMAS * sigma
    steps = _steps(pose)
    for k in range(steps):
        row, column = _centre(pose, (k + 0.5) / steps - 0.5)
        top, bottom = _span(outer * stretch, row, rows)
        for i in range(top, bottom):
            dr = (i - row) / stretch
            left, right = _span(math.sqrt(max(outer * outer - dr * dr, 0.0)), column, columns)
            for j in range(left, right):
                dc = j - column
                away = math.sqrt(dr * dr + dc * dc)
                at = (radius - away) / sigma
                if at >= FURTHEST_SIGMAS or away == 0.0:
                    continue
                u, v = dr / away, dc / away
                _shading(u, v, terms)
                limb = max(radius, away)
                contrast = _learned(table, dr / limb, dc / limb) - ground[i, j]
                for m in range(TERMS):
                    contrast += light[m] * terms[m]
                density = INVERSE_ROOT_TWO_PI * math.exp(-0.5 * at * at) / (sigma * steps)
                found[0, i, j] += contrast * density * u / stretch
                found[1, i, j] += contrast * density * v


@part
def _gather(
    window: NDArray[np.float64],
    shown: NDArray[np.float64],
    moving: NDArray[np.float64],
    light: NDArray[np.float64],
    sums: NDArray[np.float64],
) -> None:
    """Sum the normal equations over the pixels that the ball covers.

    Parameters
    ----------
    window
        Light, ground, weight; the fourth layer is filled with light less model.
    shown, moving
        Of `cover` and `rim`.
    sums
        Filled: matrix and right side; below them the squares and the number of pixels.
    """
    _, rows, columns = window.shape
    slopes = np.empty(UNKNOWNS)
    sums[:] = 0.0
    for i in range(rows):
        for j in range(columns):
            a, w = shown[0, i, j], window[WEIGHT, i, j]
            if a <= LEAST_COVER:
                window[RESIDUAL, i, j] = window[0, i, j] - window[GROUND, i, j]
                continue
            off = window[0, i, j] - window[GROUND, i, j] * (1.0 - a) - shown[LIGHT, i, j]
            for k in range(TERMS):
                off -= light[k] * shown[k, i, j]
            window[RESIDUAL, i, j] = off
            if w <= 0.0:
                continue
            slopes[0], slopes[1] = moving[0, i, j], moving[1, i, j]
            for k in range(TERMS):
                slopes[2 + k] = shown[k, i, j]
            sums[UNKNOWNS, 0] += w * off * off
            sums[UNKNOWNS, 1] += 1.0
            for k in range(UNKNOWNS):
                sums[k, UNKNOWNS] += w * slopes[k] * off
                for m in range(k + 1):
                    sums[k, m] += w * slopes[k] * slopes[m]
    for k in range(UNKNOWNS):
        sums[k, k] += 1e-9 * (1.0 + sums[k, k])
        for m in range(k):
            sums[m, k] = sums[k, m]


@compiled
def fit_place(
    window: NDArray[np.float64], start: NDArray[np.float64], table: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Fit a ball's place and shading to the pixels about it (Gauss-Newton).

    Parameters
    ----------
    window
        Light, ground, weight of each pixel (0: saturated), and room for what is left of the light;
        shape (WINDOW, rows, columns).
    start
        Pose as `cover` has it; its place is where the fit begins.
    table
        Learned light beyond the smooth shading, shape (MAP_SIDE, MAP_SIDE).

    Returns
    -------
    Row, column, their standard errors for a residual of this size, mean square of the residual
    per pixel about the ball, number of such pixels (0: no fit), way from the start; shape (7,).
    """
    _, rows, columns = window.shape
    shown = np.empty((LAYERS, rows, columns))
    moving = np.zeros((2, rows, columns))
    ground = np.ascontiguousarray(window[GROUND])
    pose, light = start.copy(), np.zeros(TERMS)
    sums = np.zeros((UNKNOWNS + 1, UNKNOWNS + 1))
    found = np.zeros(7)
    for passing in range(PASSES):
        cover(pose, table, shown)
        if passing > 0:
            rim(pose, light, table, ground, moving)
        _gather(window, shown, moving, light, sums)
        if sums[UNKNOWNS, 1] < 3 * UNKNOWNS:
            return found
        if passing == 0:
            # The light first: before it is known no place can be told.
            sums[0, 0] = sums[1, 1] = 1.0
        matrix = np.ascontiguousarray(sums[:UNKNOWNS, :UNKNOWNS])
        step = np.linalg.solve(matrix, np.ascontiguousarray(sums[:UNKNOWNS, UNKNOWNS]))
        light += step[2:]
        moved = math.sqrt(step[0] ** 2 + step[1] ** 2)
        pose[:2] += min(1.0, LARGEST_STEP_PX / max(moved, 1e-9)) * step[:2]
        if passing > 1 and moved < SETTLED_PX:
            break
    count = sums[UNKNOWNS, 1]
    scale = sums[UNKNOWNS, 0] / max(1.0, count - UNKNOWNS)
    inverse = np.linalg.inv(np.ascontiguousarray(sums[:UNKNOWNS, :UNKNOWNS]))
    found[:2] = pose[:2]
    found[2], found[3] = math.sqrt(scale * inverse[0, 0]), math.sqrt(scale * inverse[1, 1])
    found[4], found[5] = scale, count
    found[6] = math.sqrt((pose[0] - start[0]) ** 2 + (pose[1] - start[1]) ** 2)
    return found


@compiled
def add_light(
    residual: NDArray[np.float64],
    covered: NDArray[np.float64],
    pose: NDArray[np.float64],
    sums: NDArray[np.float64],
) -> None:
    """Add a frame's residual to what the film teaches of the ball's light.

    Parameters
    ----------
    residual, covered
        Light less model, and share of the exposure; shape (rows, columns).
    pose
        As `cover` has it.
    sums
        Weighted sum and weight of each cell, shape (2, MAP_SIDE, MAP_SIDE).
    """
    rows, columns = residual.shape
    for i in range(rows):
        for j in range(columns):
            a = covered[i, j]
            if a < LEAST_TAUGHT:
                continue
            u, v = (i - pose[0]) / (pose[RADIUS] * pose[STRETCH]), (j - pose[1]) / pose[RADIUS]
            limb = max(1.0, math.sqrt(u * u + v * v))
            u, v = u / limb, v / limb
            p, q = (u / MAP_REACH + 1.0) * MAP_STEPS, (v / MAP_REACH + 1.0) * MAP_STEPS
            m, n = math.floor(p), math.floor(q)
            if m < 0 or n < 0 or m >= MAP_SIDE - 1 or n >= MAP_SIDE - 1:
                continue
            f, g = p - m, q - n
            for k in range(2):
                for b in range(2):
                    share = (f if k else 1 - f) * (g if b else 1 - g)
                    sums[0, m + k, n + b] += share * a * residual[i, j]
                    sums[1, m + k, n + b] += share * a * a
