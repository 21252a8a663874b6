"""A sphere's look in one view drawn once, so that every pixel of every frame only looks it up.

The blurred disc is a profile against the square of the distance from its centre: no root is
needed. The blurred shading divided by the disc is smooth; it lies on a square grid.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import compiled, part
from analysis.photometric.shading import DISC, ORDER, STEPS_PER_RADIUS

Floats = NDArray[np.float64]

SPAN = 1.2
"""Half side of the grid in radii; beyond it the shading stays as at its edge."""
NODES_PER_PX = 2.5
FEWEST, MOST = 32, 128
"""Nodes along half a side."""
SQUARE_STEPS = 512.0
"""Of the disc's profile for each unit of the square."""
FAINTEST = 1e-3
"""Of the disc: further out the shading divided by it is taken as constant."""


def grid_size(radius_px: float) -> int:
    """Return the number of nodes along a side."""
    return 2 * int(np.clip(round(SPAN * NODES_PER_PX * radius_px), FEWEST, MOST)) + 1


def draw(templates: Sequence[Floats], reliefs: Floats, radius_px: float) -> tuple[Floats, Floats]:
    """Return disc profiles, shape (V, steps), and surfaces, shape (V, n, n), of V views.

    Parameters
    ----------
    templates
        Of `shading.template`, one for each view.
    reliefs
        What they leave, on square grids from -1 to 1, shape (V, m, m).
    radius_px
        Radius of the disc; it sets the spacing of the grid.
    """
    size = grid_size(radius_px)
    surfaces = np.empty((len(templates), size, size))
    for table, relief, surface in zip(templates, reliefs, surfaces, strict=True):
        draw_surface(table, relief, surface)
    reach = max(len(table) for table in templates) / STEPS_PER_RADIUS
    rho = np.sqrt(np.arange(math.ceil(reach**2 * SQUARE_STEPS) + 2) / SQUARE_STEPS)
    discs = [
        np.interp(rho, np.arange(len(t)) / STEPS_PER_RADIUS, t[:, DISC], right=0.0)
        for t in templates
    ]
    return np.stack(discs), surfaces


@compiled
def draw_surface(table: Floats, relief: Floats, surface: Floats) -> None:
    """Fill a grid of (row, column) from -SPAN to SPAN with the light of the unmarked sphere.

    Parameters
    ----------
    table
        Of `shading.template`.
    relief
        What it leaves, on a square grid from -1 to 1, shape (m, m).
    surface
        Filled, shape (n, n).
    """
    half = (surface.shape[0] - 1) * 0.5
    furthest = table.shape[0] - 2
    while furthest > 0 and table[furthest, DISC] < FAINTEST:
        furthest -= 1
    for a in range(surface.shape[0]):
        u = (a / half - 1.0) * SPAN
        for b in range(surface.shape[1]):
            v = (b / half - 1.0) * SPAN
            rho = math.sqrt(u * u + v * v)
            c, s = (u / rho, v / rho) if rho > 1e-9 else (1.0, 0.0)
            place = min(rho * STEPS_PER_RADIUS, float(furthest))
            i = int(place)
            t = place - i
            value = (1 - t) * table[i, 0] + t * table[i + 1, 0]
            cm, sm = 1.0, 0.0
            for m in range(1, ORDER + 1):
                cm, sm = cm * c - sm * s, sm * c + cm * s
                value += ((1 - t) * table[i, 2 * m - 1] + t * table[i + 1, 2 * m - 1]) * cm
                value += ((1 - t) * table[i, 2 * m] + t * table[i + 1, 2 * m]) * sm
            disc = (1 - t) * table[i, DISC] + t * table[i + 1, DISC]
            surface[a, b] = value / disc + relief_at(relief, u, v)


@part
def relief_at(relief: Floats, u: float, v: float) -> float:
    """Return a relief at a point, bilinear between nodes; 0 beyond its grid."""
    half = (relief.shape[0] - 1) * 0.5
    a, b = (u + 1.0) * half, (v + 1.0) * half
    if a < 0.0 or b < 0.0 or a >= 2 * half or b >= 2 * half:
        return 0.0
    i, j = int(a), int(b)
    a, b = a - i, b - j
    low = (1 - b) * relief[i, j] + b * relief[i, j + 1]
    high = (1 - b) * relief[i + 1, j] + b * relief[i + 1, j + 1]
    return float((1 - a) * low + a * high)
