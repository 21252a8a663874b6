"""The scene without spheres, and the noise of a pixel, from the frames of a shot themselves."""

from __future__ import annotations

import math

import numpy as np

from analysis.arrays import Floats, Singles
from analysis.compiled import compiled

DEGREE = 4
KEEP_OFF_PX = 4.0
LEAST_COUNT = 2
FEW = 9
"""Frames of the first guess."""
EVERY = 3
"""Share of rows and columns that the smooth surface is fitted to."""


@compiled
def uncovered_sums(
    frames: Singles, discs: Floats, sums: Floats, squares: Floats, counts: Floats
) -> None:
    """Add up each pixel over the frames in which no disc is near it.

    Parameters
    ----------
    discs
        Row, column and radius of each disc of each frame, shape (frames, discs, 3).
    sums, squares, counts
        Filled, shape (rows, columns).
    """
    width = frames.shape[2]
    clear = np.empty(width)
    for i in range(frames.shape[1]):
        for k in range(frames.shape[0]):
            clear[:] = 1.0
            for n in range(discs.shape[1]):
                off, reach = i - discs[k, n, 0], discs[k, n, 2] + KEEP_OFF_PX
                if abs(off) >= reach:
                    continue
                half = math.sqrt(reach * reach - off * off)
                first = max(math.floor(discs[k, n, 1] - half) + 1, 0)
                for j in range(first, min(math.ceil(discs[k, n, 1] + half), width)):
                    clear[j] = 0.0
            for j in range(width):
                grey = clear[j] * frames[k, i, j]
                sums[i, j] += grey
                squares[i, j] += grey * grey
                counts[i, j] += clear[j]


def background_of(frames: Singles, discs: Floats) -> tuple[Floats, float]:
    """Return the background, shape (rows, columns), and the noise of a pixel, grey levels.

    A smooth surface goes through what is seen between the spheres; each pixel then follows its
    own mean as far as its count and the roughness of the scene allow (shrinkage), so that a
    smooth scene costs no noise and a rough one is still taken as it is.

    Parameters
    ----------
    frames
        Shape (frames, rows, columns).
    discs
        Row, column and radius of each disc of each frame, shape (frames, discs, 3).
    """
    shape = frames.shape[1:]
    sums, squares, counts = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    uncovered_sums(frames, discs, sums, squares, counts)
    often = counts >= LEAST_COUNT
    mean = np.where(often, sums / np.maximum(counts, 1.0), 0.0)
    spread = np.maximum(squares - counts * mean**2, 0.0)[often]
    freedom = counts[often] - 1.0
    # The median of chi-squared over its freedom is about 1 - 2/9f cubed; it ignores flicker.
    middle = (1 - 2 / (9 * freedom)) ** 3
    noise2 = float(np.median(spread / freedom / middle)) if often.any() else 1 / 12
    noise2 = max(noise2, 1 / 12)
    smooth = _surface(mean, counts, shape)
    rough = np.where(often, mean - smooth, 0.0)
    texture = max(float((rough[often] ** 2 - noise2 / counts[often]).mean()), 0.0)
    follow = texture / (texture + noise2 / np.maximum(counts, 1e-9))
    return smooth + np.where(often, follow * rough, 0.0), float(np.sqrt(noise2))


def _surface(mean: Floats, counts: Floats, shape: tuple[int, ...]) -> Floats:
    """Return a polynomial surface through the seen pixels, by their counts."""
    rows, columns = np.linspace(-1, 1, shape[0]), np.linspace(-1, 1, shape[1])
    powers = [(i, j) for i in range(DEGREE + 1) for j in range(DEGREE + 1 - i)]
    along = np.polynomial.chebyshev.chebvander(rows, DEGREE)
    across = np.polynomial.chebyshev.chebvander(columns, DEGREE)
    thin = np.s_[::EVERY, ::EVERY]
    design = np.stack([np.outer(along[::EVERY, i], across[::EVERY, j]).ravel() for i, j in powers])
    weighted = design * counts[thin].ravel()
    # Chebyshev's polynomials are nearly at right angles: their squares stay well conditioned.
    solution = np.linalg.lstsq(weighted @ design.T, weighted @ mean[thin].ravel(), rcond=None)[0]
    grid = np.zeros((DEGREE + 1, DEGREE + 1))
    for (i, j), value in zip(powers, solution, strict=True):
        grid[i, j] = value
    return np.asarray(along @ grid @ across.T)


def first_background(frames: Singles) -> Floats:
    """Return the median over a few frames: the still background, before any disc is known."""
    few = list(frames[:: max(1, len(frames) // FEW)][:FEW])
    # Exchanging whole frames sorts every pixel; the upper half alone gives the median.
    for last in range(len(few) - 1, len(few) // 2 - 1, -1):
        for k in range(last):
            few[k], few[k + 1] = np.minimum(few[k], few[k + 1]), np.maximum(few[k], few[k + 1])
    return np.asarray(few[len(few) // 2], dtype=np.float64)
