"""The shading of a sphere in each view, fitted to all its frames at once."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.photometric.camera import Optics, disc_of
from analysis.photometric.compiled import compiled
from analysis.photometric.pose import KEEP_OFF_PX, Look, Scene, cover_canvas
from analysis.photometric.residual import (
    LEAST_DISC,
    UNKNOWNS,
    biweight,
    hidden,
    model_pixel,
    pixel_row,
    shade,
)
from analysis.photometric.shading import HARMONICS, NUDGE, ORDER, RADIALS, STEPS_PER_RADIUS

Floats = NDArray[np.float64]

ANGULAR = np.array([RADIALS[j].angular for j, _ in HARMONICS])
SINE = np.array([sine for _, sine in HARMONICS])
RADIAL = np.array([j for j, _ in HARMONICS])
COMMON = 4
"""Behind the harmonics: a shift of all frames along row and column, log radius, blur."""


@compiled
def basis(profiles: Floats, u: float, v: float, values: Floats) -> None:
    """Fill the blurred harmonics at a point of the disc, shape (harmonics,)."""
    rho = math.sqrt(u * u + v * v)
    place = rho * STEPS_PER_RADIUS
    i = int(place)
    t = place - i
    c, s = (u / rho, v / rho) if rho > 1e-9 else (1.0, 0.0)
    cosines, sines = np.ones(ORDER + 1), np.zeros(ORDER + 1)
    for m in range(1, ORDER + 1):
        cosines[m] = cosines[m - 1] * c - sines[m - 1] * s
        sines[m] = sines[m - 1] * c + cosines[m - 1] * s
    for h in range(RADIAL.shape[0]):
        j = RADIAL[h]
        value = (1 - t) * profiles[i, j] + t * profiles[i + 1, j]
        values[h] = value * (sines[ANGULAR[h]] if SINE[h] else cosines[ANGULAR[h]])


@compiled
def shading_equations(
    scene: Scene,
    optics: Optics,
    look: Look,
    tables: tuple[Floats, Floats],
    view: int,
    centre: Floats,
    rotation: Floats,
    light: Floats,
    others: Floats,
    limit: float,
    normal: Floats,
    right: Floats,
) -> None:
    """Add one frame to the normal equations of a view's shading, pose and light being kept.

    Parameters
    ----------
    tables
        Of `shading.blurred_profiles` at this view's blur, and the template NUDGE pixels wider.
    light
        The frame's offset, gain and slopes, shape (4,).
    normal, right
        Added to: the change of each coefficient, then COMMON; shapes (n, n), lower triangle, (n,).
    """
    place = disc_of(optics, view, centre, look.radius_m)
    directions = (look.markers @ rotation.T) @ optics.axes[view].T
    shape = (scene.image.shape[0], scene.image.shape[1])
    canvas, corner = cover_canvas(look, view, directions, place, shape)
    seen, nudged = np.zeros(12), np.zeros(12)
    harmonics = RADIAL.shape[0]
    size = harmonics + COMMON
    row, own_row = np.zeros(size), np.zeros(UNKNOWNS)
    profiles, blurred = tables
    for i in range(canvas.shape[1]):
        y = corner[0] + i
        if y < optics.rows[view, 0] or y >= optics.rows[view, 1]:
            continue
        u = (y - place[0]) / place[2]
        for j in range(canvas.shape[2]):
            x = corner[1] + j
            v = (x - place[1]) / place[2]
            if not shade(look.tables[view], look.reliefs[view], u, v, seen):
                continue
            if seen[3] < LEAST_DISC or hidden(y, x, others, KEEP_OFF_PX):
                continue
            behind, cover = scene.background[y, x], canvas[0, i, j]
            model = pixel_row(seen, canvas, i, j, behind, light, look.darkness, place[2], own_row)
            residual = scene.image[y, x] - model
            left = 1.0 - look.darkness * cover / seen[3]
            # Where a marker lies, its own error would be learned as shading.
            weight = biweight(residual, limit * scene.noise) * max(left, 0.0) ** 2
            if weight == 0.0:
                continue
            basis(profiles, u, v, row)
            for h in range(harmonics):
                row[h] *= light[1] * left
            row[harmonics], row[harmonics + 1] = own_row[0], own_row[1]
            shade(
                look.tables[view], look.reliefs[view], u / (1.0 + NUDGE), v / (1.0 + NUDGE), nudged
            )
            there = model_pixel(nudged, cover, behind, light, look.darkness)
            row[harmonics + 2] = (there - model) / NUDGE
            shade(blurred, look.reliefs[view], u, v, nudged)
            there = model_pixel(nudged, cover, behind, light, look.darkness)
            row[harmonics + 3] = (there - model) / NUDGE
            weight /= scene.noise**2
            for a in range(size):
                scaled = weight * row[a]
                right[a] += scaled * residual
                for b in range(a + 1):
                    normal[a, b] += scaled * row[b]
