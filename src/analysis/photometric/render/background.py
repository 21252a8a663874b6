"""The scene without spheres, a pixel's noise, and lines that see nothing, from the frames alone."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Grey, Singles, grey_like
from analysis.compiled import compiled

DEGREE = 4
KEEP_OFF_PX = 4.0
LEAST_COUNT = 2
FEW, LOOKED_AT = 9, 9
"""Frames of the first guess, and those in which dead lines are looked for."""
THIN = np.s_[::3, ::3]
"""Rows and columns that the smooth surface is fitted to, and a pixel's noise is taken from."""
LEAST_VARIANCE = 1 / 12
"""Of whole grey levels, by rounding."""


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
    noise2 = _variance(sums[THIN], squares[THIN], counts[THIN])
    smooth = _surface(mean, counts, shape)
    rough = np.where(often, mean - smooth, 0.0)
    texture = max(float((rough[often] ** 2 - noise2 / counts[often]).mean()), 0.0)
    follow = texture / (texture + noise2 / np.maximum(counts, 1e-9))
    return smooth + np.where(often, follow * rough, 0.0), float(np.sqrt(noise2))


def _variance(sums: Floats, squares: Floats, counts: Floats) -> float:
    """Return a pixel's variance, grey levels squared, by the scatter of some about their means.

    That of rounding at least.
    """
    often = counts >= LEAST_COUNT
    if not often.any():
        return LEAST_VARIANCE
    seen, freedom = counts[often], counts[often] - 1.0
    spread = np.maximum(squares[often] - sums[often] ** 2 / seen, 0.0)
    # The median of chi-squared over its freedom is about 1 - 2/9f cubed; it ignores flicker.
    root = 1 - 2 / (9 * freedom)
    return max(float(np.median(spread / (freedom * root * root * root))), LEAST_VARIANCE)


def _surface(mean: Floats, counts: Floats, shape: tuple[int, ...]) -> Floats:
    """Return a polynomial surface through the seen pixels, by their counts."""
    rows, columns = np.linspace(-1, 1, shape[0]), np.linspace(-1, 1, shape[1])
    powers = [(i, j) for i in range(DEGREE + 1) for j in range(DEGREE + 1 - i)]
    along = np.polynomial.chebyshev.chebvander(rows, DEGREE)
    across = np.polynomial.chebyshev.chebvander(columns, DEGREE)
    down, right = THIN
    design = np.stack([np.outer(along[down, i], across[right, j]).ravel() for i, j in powers])
    weighted = design * counts[THIN].ravel()
    # Chebyshev's polynomials are nearly at right angles: their squares stay well conditioned.
    solution = np.linalg.lstsq(weighted @ design.T, weighted @ mean[THIN].ravel(), rcond=None)[0]
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


CHANGES, STILL = 15.0, 6.0
"""Range over those frames in units of the noise: at least, where spheres pass; noise alone."""
LEAST_SHARE, LEAST_PASSED = 0.9, 8
"""Of a line's pixels that stand still although those beside them change, and how many do."""
WIDEST = 2
"""Dead lines side by side."""


def dead_lines(frames: Grey, noise: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the rows and the columns that do not change although those on either side do.

    A line that no sphere passes is left alone: it does no harm.

    Parameters
    ----------
    frames
        Grey levels, shape (frames, rows, columns).
    noise
        Standard deviation of a pixel, grey levels.
    """
    few = frames[:: max(1, len(frames) // LOOKED_AT)][:LOOKED_AT]
    change: Grey = few.max(axis=0) - few.min(axis=0)
    return _blind(change, noise), _blind(change.T, noise)


def _blind(change: Grey, noise: float) -> NDArray[np.intp]:
    """Return the rows that do not follow, of the range of each pixel."""
    around = np.pad(change, ((WIDEST, WIDEST), (0, 0)))
    count = len(change)
    before = np.maximum(around[:count], around[1 : count + 1])
    after = np.maximum(around[WIDEST + 1 : -1], around[2 * WIDEST :])
    passed = np.minimum(before, after) > CHANGES * noise
    frozen = passed & (change < STILL * noise)
    often = passed.sum(axis=1)
    return np.flatnonzero((often >= LEAST_PASSED) & (frozen.sum(axis=1) >= LEAST_SHARE * often))


def filled(frames: Grey, noise: float) -> Grey:
    """Return the frames with dead lines filled in from the nearest live ones on either side.

    A line of a disc at the sensor's own grey level cuts the edges of the start and pulls at the
    pose. What is filled in is wrong by the bend of the image across the line. The same array
    comes back where every line sees.

    Parameters
    ----------
    frames, noise
        As for `dead_lines`.
    """
    rows, columns = dead_lines(frames, noise)
    if not len(rows) and not len(columns):
        return frames
    whole = frames.copy()
    _fill(whole, rows)
    _fill(whole.transpose(0, 2, 1), columns)
    return whole


def _fill(frames: Grey, dead: NDArray[np.intp]) -> None:
    """Fill rows in place, linearly between the live ones."""
    live = np.setdiff1d(np.arange(frames.shape[1]), dead)
    for row in dead:
        after = int(np.searchsorted(live, row))
        low, high = live[after - 1], live[after]
        share = (row - low) / (high - low)
        mixed = (1.0 - share) * frames[:, low] + share * frames[:, high]
        frames[:, row] = grey_like(mixed, frames)
