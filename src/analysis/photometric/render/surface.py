"""A sphere's look in one view drawn once, so that every pixel of every frame only looks it up.

The blurred disc is a profile against the square of the distance from its centre: no root is
needed. The blurred shading divided by the disc is smooth; it lies on a square grid.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from analysis.arrays import Floats
from analysis.compiled import compiled, part
from analysis.photometric.render.shading import DISC, ORDER, STEPS_PER_RADIUS

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
    last, turns, parts = surface.shape[0] - 1, np.zeros((2, ORDER + 1)), np.zeros((2, 2))
    for a in range(surface.shape[0] // 2, surface.shape[0]):
        u = (a / half - 1.0) * SPAN
        for b in range(surface.shape[0] // 2, surface.shape[0]):
            v = (b / half - 1.0) * SPAN
            rho = math.sqrt(u * u + v * v)
            c, s = (u / rho, v / rho) if rho > 1e-9 else (1.0, 0.0)
            place = min(rho * STEPS_PER_RADIUS, float(furthest))
            i = int(place)
            t = place - i
            turns[0, 0], turns[1, 0] = 1.0, 0.0
            for m in range(1, ORDER + 1):
                turns[0, m] = turns[0, m - 1] * c - turns[1, m - 1] * s
                turns[1, m] = turns[1, m - 1] * c + turns[0, m - 1] * s
            add_up(table[i], table[i + 1], t, turns, parts)
            # Mirrored in u, odd cosines and even sines turn their sign; in v all sines do.
            for up in range(2):
                sign = 1.0 - 2.0 * up
                even, odd = parts[0, 0] + sign * parts[0, 1], parts[1, 1] + sign * parts[1, 0]
                row = last - a if up else a
                surface[row, b] = even + odd + relief_at(relief, sign * u, v)
                surface[row, last - b] = even - odd + relief_at(relief, sign * u, -v)


@part
def add_up(low: Floats, high: Floats, t: float, turns: Floats, parts: Floats) -> None:
    """Sum a template between two of its rows, over the disc.

    Parameters
    ----------
    turns
        Cosines and sines of the multiples of the angle, shape (2, ORDER + 1).
    parts
        Filled with the cosines' and the sines' part, those of even and of odd order, shape (2, 2).
    """
    disc = (1 - t) * low[DISC] + t * high[DISC]
    parts[0, 0], parts[0, 1] = ((1 - t) * low[0] + t * high[0]) / disc, 0.0
    parts[1, 0], parts[1, 1] = 0.0, 0.0
    for m in range(1, ORDER + 1):
        for sine in range(2):
            value = (1 - t) * low[2 * m - 1 + sine] + t * high[2 * m - 1 + sine]
            parts[sine, m % 2] += value * turns[sine, m] / disc


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
