"""The shading of a sphere in each view, fitted to all its frames at once."""

from __future__ import annotations

import math

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
