"""The shading of both spheres in all views, fitted to all frames at once, with radius and blur.

A shift of the disc, its radius, its blur and shading near the limb resemble each other, so they
are solved together; in turn they would creep towards the solution for ever.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.compiled import compiled, part
from analysis.photometric.learn.relief import FULL_TO, NONE_FROM
from analysis.photometric.learn.training_view import TrainingView, drawn_for_bundle
from analysis.photometric.render.bands import ACROSS, BAND, DOWN, LANES
from analysis.photometric.render.pixel_rows import (
    BESIDE,
    LEFT,
    OF_LIMB,
    OF_SHADING,
    WIDTH,
    add_squares,
    fill_rows,
    lay_pixels,
    pixels_of,
)
from analysis.photometric.render.shading import HARMONICS, RADIALS
from analysis.photometric.render.sight import Equations, Sight, Stance

COMMON = 4
"""Behind the harmonics: a shift of all frames along row and column, log radius, blur."""
USED = np.array([*range(OF_SHADING, WIDTH - 1), 0, 1, OF_LIMB, OF_LIMB + 1, WIDTH - 1])
"""Columns of a pixel's row that take part, in this order, the residual last."""


@part
def _share(lanes: Floats, n: int, inside: float) -> float:
    """Return the share that a pixel has in the shading.

    Where a marker lies, its own error would be learned as shading. Where a relief ends, at the
    limb, shading alone can follow, and it must not be held back by the inside: what it leaves there
    the relief takes at once, but fitted in turns the two would creep to where they belong.
    """
    band = lanes.reshape(-1)
    u, v = band[DOWN + np.uint64(n)], band[ACROSS + np.uint64(n)]
    covered = (NONE_FROM - math.sqrt(u * u + v * v)) / (NONE_FROM - FULL_TO)
    kept = 1.0 - (1.0 - inside) * min(max(covered, 0.0), 1.0)
    return float(lanes[-BESIDE + LEFT, n]) * kept


@compiled
def shading_equations(
    sight: Sight, stance: Stance, view: int, training: TrainingView, equations: Equations
) -> None:
    """Add one frame to the normal equations of a view's shading, pose and light being kept.

    Parameters
    ----------
    equations
        Of the change of each coefficient, then COMMON.
    """
    drawn = drawn_for_bundle(sight, stance, view, training)
    y, x = pixels_of(drawn, sight.optics.rows[view])
    size = USED.shape[0]
    products, own = np.zeros((size, size)), np.zeros((BAND, size))
    lanes, wider, rows = (
        np.zeros((LANES + BESIDE, BAND)),
        np.zeros(LANES * BAND),
        np.zeros((BAND, WIDTH)),
    )
    for first in range(0, y.shape[0], BAND):
        pixels = y[first : first + BAND], x[first : first + BAND]
        count = pixels[0].shape[0]
        lay_pixels(sight.scene, drawn, sight.others[view], pixels, lanes)
        fill_rows(sight.scene, drawn, training.limit, (lanes, wider), rows[:count])
        for n in range(count):
            share = _share(lanes, n, training.inside)
            for k in range(size):
                own[n, k] = rows[n, USED[k]] * share
        add_squares(own[:count], products)
    for a in range(size - 1):
        equations.right[a] += products[size - 1, a]
        for b in range(a + 1):
            equations.normal[a, b] += products[a, b]


ALIKE, HIGH = 0.02, 0.1
"""How far the spheres' coefficients differ, and how large those above order two are, expected as
a share of the brightness: the same light falls on both, and it is smooth."""
ORDINARY = 2
SHIFT_PX, LOG_RADIUS, BLUR_PX = 0.3, 0.02, 0.2
"""Expected sizes of a correction."""

DEGREE = np.array([RADIALS[j].power + RADIALS[j].height for j, _ in HARMONICS])


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Solved shading.

    Attributes
    ----------
    shading
        Coefficients, shape (2, V, harmonics).
    log_radius, log_radius_sigma
        Correction common to all discs, and its standard error.
    blur_px
        Correction of the blur in each view, shape (V,).
    """

    shading: Floats
    log_radius: float
    log_radius_sigma: float
    blur_px: Floats


def solve_shading(normal: Floats, right: Floats, shading: Floats, *, hold_radius: bool) -> Surface:
    """Solve for the shading of both spheres in all views, one radius and a blur for each view.

    Parameters
    ----------
    normal, right
        Of `shading_fit.shading_equations`, shapes (2, V, n, n) and (2, V, n).
    shading
        Present coefficients, shape (2, V, harmonics).
    """
    views, harmonics = shading.shape[1:]
    block = harmonics + 2
    size = 2 * views * block + 1 + views
    whole, aim = np.zeros((size, size)), np.zeros(size)
    for i in (0, 1):
        for v in range(views):
            first = (i * views + v) * block
            at = [*range(first, first + block), size - views - 1, size - views + v]
            own = normal[i, v] + np.tril(normal[i, v], -1).T
            whole[np.ix_(at, at)] += own
            aim[at] += right[i, v]
    _add_priors(whole, aim, shading, hold_radius=hold_radius)
    step = np.linalg.solve(whole, aim)
    radius = size - views - 1
    variance = np.linalg.inv(whole)[radius, radius]
    changes = step[: 2 * views * block].reshape(2, views, block)[..., :harmonics]
    return Surface(
        shading=shading + changes,
        log_radius=float(step[radius]),
        log_radius_sigma=float(np.sqrt(variance)),
        blur_px=step[radius + 1 :],
    )


def _add_priors(whole: Floats, aim: Floats, shading: Floats, *, hold_radius: bool) -> None:
    views, harmonics = shading.shape[1:]
    block = harmonics + COMMON - 2
    for v in range(views):
        level = max(float(np.abs(shading[:, v, 0]).max()), 1.0)
        alike = 1.0 / (ALIKE * level) ** 2
        high = np.where(DEGREE > ORDINARY, 1.0 / (HIGH * level) ** 2, 1e-6 * alike)
        a, b = v * block, (views + v) * block
        for h in range(harmonics):
            p, q = a + h, b + h
            apart = shading[0, v, h] - shading[1, v, h]
            whole[[p, q], [p, q]] += alike
            whole[[p, q], [q, p]] -= alike
            aim[p] -= alike * apart
            aim[q] += alike * apart
            for at, i in ((p, 0), (q, 1)):
                whole[at, at] += high[h]
                aim[at] -= high[h] * shading[i, v, h]
        for at in (a + harmonics, a + harmonics + 1, b + harmonics, b + harmonics + 1):
            whole[at, at] += SHIFT_PX**-2
    radius = len(whole) - views - 1
    whole[radius, radius] += 1e20 if hold_radius else LOG_RADIUS**-2
    for v in range(views):
        whole[radius + 1 + v, radius + 1 + v] += BLUR_PX**-2
