"""What smooth shading leaves of a sphere's look: terminator, highlight, reflections of the rig.

A map over the inside of the disc, the mean residual of all frames of a shot, markers left out. It
ends short of the limb, where it could pass for a larger or shifted disc.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter

from analysis.arrays import Floats
from analysis.compiled import compiled
from analysis.photometric.render.covers import cover_canvas, paint_of
from analysis.photometric.render.residual import (
    LEAST_DISC,
    LOOK,
    biweight,
    cover_at,
    hidden,
    model_pixel,
    shade,
)
from analysis.photometric.render.sight import Sight, Stance

NODES_PER_PX = 0.8
FEWEST, MOST = 8, 48
"""Nodes along a radius."""
SMOOTH_NODES = 0.7
FULL_TO, NONE_FROM = 0.88, 0.97
"""In radii."""
SIZE = 0.1
"""Expected size of a relief as a share of the brightness."""


def nodes_for(radius_px: float) -> int:
    """Return the number of nodes along a side of a relief."""
    return 2 * int(np.clip(round(NODES_PER_PX * radius_px), FEWEST, MOST)) + 1


@compiled
def add_residuals(
    sight: Sight, stance: Stance, view: int, limit: float, nodes: tuple[Floats, Floats]
) -> None:
    """Spread the residuals of one frame over the nodes of a relief.

    Parameters
    ----------
    nodes
        Weighted residuals and weights over the noise's variance, added to, shapes (n, n).
    """
    sums, weights = nodes
    scene, look = sight.scene, sight.look
    canvas, corner, place = cover_canvas(sight, stance, view)
    light, rows = stance.lights[view], sight.optics.rows[view]
    paint = paint_of(sight, stance, view, place[2])
    seen = np.zeros(LOOK)
    half = (sums.shape[0] - 1) * 0.5
    for i in range(canvas.shape[0]):
        y = corner[0] + i
        if y < rows[0] or y >= rows[1]:
            continue
        u = (y - place[0]) / place[2]
        for j in range(canvas.shape[2]):
            x = corner[1] + j
            v = (x - place[1]) / place[2]
            if u * u + v * v >= 1.0 or hidden(scene, y, x, sight.others[view]):
                continue
            shade(look.discs[view], look.surfaces[view], u, v, seen)
            cover = cover_at(canvas, i, j)
            model = model_pixel(seen, cover, scene.background[y, x], paint)
            residual = scene.image[y, x] - model
            left = 1.0 - look.darkness * cover[0] / max(seen[0], LEAST_DISC)
            # What a marker hides, its own error would be learned as relief.
            weight = biweight(residual / scene.noise, limit) * max(left, 0.0) ** 8
            own = light[1] * seen[0] * left / scene.noise
            a, b = (u + 1.0) * half, (v + 1.0) * half
            p, q = int(a), int(b)
            a, b = a - p, b - q
            for n in range(4):
                share = (a if n & 1 else 1.0 - a) * (b if n & 2 else 1.0 - b) * weight
                sums[p + (n & 1), q + (n >> 1)] += share * own * residual / scene.noise
                weights[p + (n & 1), q + (n >> 1)] += share * own * own


def changed_relief(relief: Floats, nodes: tuple[Floats, Floats], level: float) -> Floats:
    """Return a relief improved by the residuals that its nodes have gathered.

    Parameters
    ----------
    nodes
        Of `add_residuals`.
    level
        Brightness of the disc, grey levels.
    """
    sums, weights = nodes
    expected = (SIZE * level) ** -2.0
    smooth = gaussian_filter(sums, SMOOTH_NODES)
    change = smooth / (gaussian_filter(weights, SMOOTH_NODES) + expected)
    axis = np.linspace(-1, 1, len(relief))
    rho = np.hypot(axis[:, None], axis[None, :])
    inner = np.clip((NONE_FROM - rho) / (NONE_FROM - FULL_TO), 0.0, 1.0)
    return np.asarray((relief + change * inner) * (rho < NONE_FROM))
