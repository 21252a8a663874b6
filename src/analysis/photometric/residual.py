"""Pixels against the rendered sphere: the normal equations of one sphere in one view.

The image of a sphere is I = (B + b)(1 - E) + S (1 - d M / E): background B with offset b, blurred
disc E, blurred shading S, cover M of the markers and their darkness d. As a marker's visible cap
lies inside the disc, this is the blurred product to first order.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.photometric.compiled import compiled
from analysis.photometric.covers import cover_canvas
from analysis.photometric.shading import DISC, ORDER, SLOPE, STEPS_PER_RADIUS
from analysis.photometric.sight import Equations, Sight, Stance

Floats = NDArray[np.float64]

UNKNOWNS = 9
"""Row, column, turns about row, column and eye; background offset; gain and slopes of the light."""
LOOK = 12
LEAST_DISC = 0.03
KEEP_OFF_PX = 2.6
"""Another disc's blurred edge reaches this far."""


@compiled
def shade(table: Floats, relief: Floats, u: float, v: float, look: Floats) -> bool:
    """Look a template up at a point of the disc.

    Parameters
    ----------
    table
        Of `shading.template`.
    relief
        What smooth shading leaves, on a square grid from -1 to 1, shape (n, n).
    u, v
        Row and column from the centre in units of the radius.
    look
        Filled with shading, disc and slope profile: value, derivative to u, to v of the shading
        (0..2), of the disc (3..5), of the profile of u (6..8) and of v (9..11).

    Returns
    -------
    False beyond the reach of the blur, where all are 0.
    """
    rho = math.sqrt(u * u + v * v)
    place = rho * STEPS_PER_RADIUS
    i = int(place)
    if i >= table.shape[0] - 1:
        return False
    t = place - i
    if rho > 1e-9:
        c, s = u / rho, v / rho
    else:
        c, s = 1.0, 0.0
    inverse = 1.0 / max(rho, 1e-9)
    value = (1 - t) * table[i, 0] + t * table[i + 1, 0]
    slope = (table[i + 1, 0] - table[i, 0]) * STEPS_PER_RADIUS
    around = 0.0
    cm, sm = 1.0, 0.0
    for m in range(1, ORDER + 1):
        cm, sm = cm * c - sm * s, sm * c + cm * s
        a0, a1 = table[i, 2 * m - 1], table[i + 1, 2 * m - 1]
        b0, b1 = table[i, 2 * m], table[i + 1, 2 * m]
        a, b = (1 - t) * a0 + t * a1, (1 - t) * b0 + t * b1
        value += a * cm + b * sm
        slope += ((a1 - a0) * cm + (b1 - b0) * sm) * STEPS_PER_RADIUS
        around += m * (b * cm - a * sm)
    look[0] = value
    look[1] = slope * c - around * s * inverse
    look[2] = slope * s + around * c * inverse
    e0, e1 = table[i, DISC], table[i + 1, DISC]
    steep = (e1 - e0) * STEPS_PER_RADIUS
    look[3], look[4], look[5] = (1 - t) * e0 + t * e1, steep * c, steep * s
    p0, p1 = table[i, SLOPE], table[i + 1, SLOPE]
    p, steep = (1 - t) * p0 + t * p1, (p1 - p0) * STEPS_PER_RADIUS
    over = p * inverse
    add_relief(relief, u, v, look)
    look[6], look[7], look[8] = p * c, steep * c * c + over * s * s, (steep - over) * c * s
    look[9], look[10], look[11] = p * s, (steep - over) * c * s, steep * s * s + over * c * c
    return True


@compiled
def add_relief(relief: Floats, u: float, v: float, look: Floats) -> None:
    """Add a relief and its slopes at a point, bilinear between nodes, to the shading."""
    half = (relief.shape[0] - 1) * 0.5
    a, b = (u + 1.0) * half, (v + 1.0) * half
    if a < 0.0 or b < 0.0 or a >= 2 * half or b >= 2 * half:
        return
    i, j = int(a), int(b)
    a, b = a - i, b - j
    at, down = relief[i, j], relief[i + 1, j]
    across, both = relief[i, j + 1], relief[i + 1, j + 1]
    look[0] += (1 - a) * ((1 - b) * at + b * across) + a * ((1 - b) * down + b * both)
    look[1] += half * ((1 - b) * (down - at) + b * (both - across))
    look[2] += half * ((1 - a) * (across - at) + a * (both - down))


@compiled
def hidden(row: int, column: int, others: Floats) -> bool:
    """Tell whether a pixel lies in, or close to, one of the other discs (row, column, radius)."""
    for n in range(others.shape[0]):
        d_r, d_c = row - others[n, 0], column - others[n, 1]
        reach = others[n, 2] + KEEP_OFF_PX
        if d_r * d_r + d_c * d_c < reach * reach:
            return True
    return False


@compiled
def model_pixel(look: Floats, cover: float, behind: float, light: Floats, darkness: float) -> float:
    """Return the grey level of a pixel.

    Parameters
    ----------
    look
        Of `shade`.
    cover
        Of the markers, 0 to 1.
    behind
        Background.
    light
        Background offset, gain, slopes along u and v.
    """
    disc = look[3]
    plain = light[1] * look[0] + light[2] * look[6] + light[3] * look[9]
    left = 1.0 - darkness * cover / max(disc, LEAST_DISC)
    return float((behind + light[0]) * (1.0 - disc) + plain * left)


@compiled
def pixel_row(
    look: Floats,
    cover: Floats,
    behind: float,
    paint: tuple[Floats, float, float],
    row: Floats,
) -> float:
    """Fill the derivatives of a pixel to the unknowns and return its grey level.

    Parameters
    ----------
    look, behind
        As for `model_pixel`.
    cover
        Of the markers with its derivatives, shape (LAYERS,).
    paint
        Light of the view, darkness of the markers, radius of the disc in pixels.
    row
        Filled, shape (UNKNOWNS,) or longer.
    """
    light, darkness, radius = paint
    disc = look[3]
    floor = max(disc, LEAST_DISC)
    plain = light[1] * look[0] + light[2] * look[6] + light[3] * look[9]
    mark = cover[0] / floor
    left = 1.0 - darkness * mark
    shadow = plain * darkness / floor
    for k in range(2):
        moved = light[1] * look[1 + k] + light[2] * look[7 + k] + light[3] * look[10 + k]
        steep = look[4 + k]
        kept = mark * steep if disc > LEAST_DISC else 0.0
        # The disc's own parts fall where the centre moves on; the cover's layers already do.
        row[k] = (
            (behind + light[0]) * steep - moved * left - shadow * kept
        ) / radius - shadow * cover[1 + k]
    for k in range(3):
        row[2 + k] = -shadow * cover[3 + k]
    row[5] = 1.0 - disc
    row[6], row[7], row[8] = look[0] * left, look[6] * left, look[9] * left
    return float((behind + light[0]) * (1.0 - disc) + plain * left)


@compiled
def biweight(residual: float, limit: float) -> float:
    """Return Tukey's weight of a residual: 1 at 0, 0 from `limit` on."""
    x = residual / limit
    return 0.0 if abs(x) >= 1.0 else (1.0 - x * x) ** 2


@compiled
def accumulate(
    sight: Sight, stance: Stance, view: int, limit: float, equations: Equations
) -> tuple[float, float, int]:
    """Add one view of one sphere to its normal equations.

    Parameters
    ----------
    limit
        Residual from which a pixel counts no more, in units of the noise.
    equations
        Of the view's UNKNOWNS.

    Returns
    -------
    Weighted sum of squares over the noise's variance, sum of weights, pixels looked at.
    """
    scene, table, relief = sight.scene, sight.look.tables[view], sight.look.reliefs[view]
    canvas, corner, place = cover_canvas(sight, stance, view)
    paint = (stance.lights[view], sight.look.darkness, place[2])
    rows, others = sight.optics.rows[view], sight.others[view]
    look, row = np.zeros(LOOK), np.zeros(UNKNOWNS)
    squares, weights, count = 0.0, 0.0, 0
    for i in range(canvas.shape[1]):
        y = corner[0] + i
        if y < rows[0] or y >= rows[1]:
            continue
        u = (y - place[0]) / place[2]
        for j in range(canvas.shape[2]):
            x = corner[1] + j
            v = (x - place[1]) / place[2]
            if not shade(table, relief, u, v, look) or hidden(y, x, others):
                continue
            model = pixel_row(look, canvas[:, i, j], scene.background[y, x], paint, row)
            residual = (scene.image[y, x] - model) / scene.noise
            weight = biweight(residual, limit)
            count += 1
            if weight == 0.0:
                continue
            squares += weight * residual * residual
            weights += weight
            weight /= scene.noise
            for a in range(UNKNOWNS):
                scaled = weight * row[a]
                equations.right[a] += scaled * residual
                scaled /= scene.noise
                for b in range(a + 1):
                    equations.normal[a, b] += scaled * row[b]
    return squares, weights, count
