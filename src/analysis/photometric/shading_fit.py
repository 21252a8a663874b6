"""The shading of a sphere in each view, fitted to all its frames at once."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from analysis.compiled import compiled, part
from analysis.photometric.covers import cover_canvas, paint_of
from analysis.photometric.residual import (
    LEAST_DISC,
    LOOK,
    UNKNOWNS,
    biweight,
    cover_at,
    hidden,
    model_pixel,
    pixel_row,
    shade,
)
from analysis.photometric.shading import HARMONICS, NUDGE, ORDER, RADIALS, STEPS_PER_RADIUS
from analysis.photometric.sight import Equations, Sight, Stance

Floats = NDArray[np.float64]

ANGULAR = np.array([RADIALS[j].angular for j, _ in HARMONICS])
SINE = np.array([sine for _, sine in HARMONICS])
HARMONIC = np.array([j for j, _ in HARMONICS])
BLOCK = 256
"""Pixels whose products are added at a time."""
COMMON = 4
"""Behind the harmonics: a shift of all frames along row and column, log radius, blur."""


@part
def basis(profiles: Floats, u: float, v: float, turns: Floats, values: Floats) -> None:
    """Fill the blurred harmonics at a point of the disc, shape (harmonics,).

    Parameters
    ----------
    turns
        Room for cosines and sines, shape (2, ORDER + 1).
    """
    rho = math.sqrt(u * u + v * v)
    place = rho * STEPS_PER_RADIUS
    i = int(place)
    t = place - i
    c, s = (u / rho, v / rho) if rho > 1e-9 else (1.0, 0.0)
    turns[0, 0], turns[1, 0] = 1.0, 0.0
    for m in range(1, ORDER + 1):
        turns[0, m] = turns[0, m - 1] * c - turns[1, m - 1] * s
        turns[1, m] = turns[1, m - 1] * c + turns[0, m - 1] * s
    for h in range(HARMONIC.shape[0]):
        j = HARMONIC[h]
        value = (1 - t) * profiles[i, j] + t * profiles[i + 1, j]
        values[h] = value * turns[SINE[h], ANGULAR[h]]


@part
def add_block(block: Floats, equations: Equations) -> None:
    """Add the products of whitened rows, their residuals last, shape (pixels, unknowns + 1)."""
    size = block.shape[1] - 1
    products = np.dot(block.T, block)
    for a in range(size):
        equations.right[a] += products[size, a]
        for b in range(a + 1):
            equations.normal[a, b] += products[a, b]


class Samples(NamedTuple):
    """What a view's shading is fitted with.

    Attributes
    ----------
    profiles
        Of `shading.blurred_profiles` at the view's blur.
    wider
        Disc and surface, the blur NUDGE pixels wider.
    limit
        Residual that counts no more, in units of the noise.
    """

    profiles: Floats
    wider: tuple[Floats, Floats]
    limit: float


@compiled
def shading_equations(
    sight: Sight, stance: Stance, view: int, samples: Samples, equations: Equations
) -> None:
    """Add one frame to the normal equations of a view's shading, pose and light being kept.

    Parameters
    ----------
    equations
        Of the change of each coefficient, then COMMON.
    """
    scene, disc, surface = sight.scene, sight.look.discs[view], sight.look.surfaces[view]
    canvas, corner, place = cover_canvas(sight, stance, view)
    light, darkness = stance.lights[view], sight.look.darkness
    rows, paint = sight.optics.rows[view], paint_of(sight, stance, view, place[2])
    seen, nudged = np.zeros(LOOK), np.zeros(LOOK)
    size = HARMONIC.shape[0] + COMMON
    block, turns, own = np.zeros((BLOCK, size + 1)), np.zeros((2, ORDER + 1)), np.zeros(UNKNOWNS)
    filled = 0
    for i in range(canvas.shape[0]):
        y = corner[0] + i
        if y < rows[0] or y >= rows[1]:
            continue
        u = (y - place[0]) / place[2]
        for j in range(canvas.shape[2]):
            x = corner[1] + j
            v = (x - place[1]) / place[2]
            if not shade(disc, surface, u, v, seen) or seen[0] < LEAST_DISC:
                continue
            if hidden(y, x, sight.others[view]):
                continue
            behind, cover = scene.background[y, x], cover_at(canvas, i, j)
            model = pixel_row(seen, (canvas, i, j), behind, paint, own)
            residual = (scene.image[y, x] - model) / scene.noise
            left = 1.0 - darkness * cover[0] / seen[0]
            # Where a marker lies, its own error would be learned as shading.
            weight = biweight(residual, samples.limit) * max(left, 0.0) ** 2
            if weight == 0.0:
                continue
            if filled == BLOCK:
                add_block(block, equations)
                filled = 0
            row = block[filled]
            filled += 1
            basis(samples.profiles, u, v, turns, row)
            for h in range(size - COMMON):
                row[h] *= light[1] * left
            row[size - 4], row[size - 3] = own[0], own[1]
            shade(disc, surface, u / (1.0 + NUDGE), v / (1.0 + NUDGE), nudged)
            there = model_pixel(nudged, cover, behind, paint)
            row[size - 2] = (there - model) / NUDGE
            shade(samples.wider[0], samples.wider[1], u, v, nudged)
            there = model_pixel(nudged, cover, behind, paint)
            row[size - 1] = (there - model) / NUDGE
            row[size] = residual * scene.noise
            root = math.sqrt(weight) / scene.noise
            for a in range(size + 1):
                row[a] *= root
    add_block(block[:filled], equations)
