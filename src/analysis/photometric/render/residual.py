"""A pixel of a rendered sphere: its grey level and how it changes with the pose.

The image of a sphere is I = (B + b)(1 - E) + L (E - d M) - d s^2 G . (grad M - M grad E / E):
background B with offset b, blurred disc E, light L of the unmarked sphere, blurred cover M of the
markers, their darkness d and the blur's standard deviation s. The last term is what blurring the
product of light and cover adds to the product of the blurred ones, to second order in s; without it
markers where the light falls off seem to lie 0.02 px further out, and the sphere 0.1 % larger.

L is the blurred light over E: near the limb that of a place s^2 grad E / E further in, where the
blur's middle lies that the limb leaves (the mean of a Gaussian that is cut off), and G = grad L / f
the slope of the bare surface, f = 1 - x (x + (1 - rho) R / s) with x = s |grad E| / E the variance
of such a Gaussian over that of a whole one. Without this a marker that the limb cuts seems to be
turned by 0.1 to 0.2 px at s = 1.2 px, and spheres whose light falls off to the limb came out up to
0.06 px too small.
"""

from __future__ import annotations

import math

from analysis.arrays import Floats
from analysis.compiled import part
from analysis.photometric.render.sight import Scene
from analysis.photometric.render.surface import SPAN, SQUARE_STEPS

Cover = tuple[float, float, float]
"""Of the markers, 0 to 1, and its derivatives to row and column of the disc's centre, 1/px."""
Paint = tuple[Floats, float, float, float]
"""Light of a view (background offset, gain, slopes along u and v), darkness of the markers, radius
of the disc, pixels, and variance of the blur, pixels squared."""

UNKNOWNS = 9
"""Row, column, turns about row, column and eye; background offset; gain and slopes of the light."""
LOOK = 8
LEAST_DISC = 0.03
LEAST_FALL = 0.2
"""Of f: further out next to nothing of a sphere is seen."""
KEEP_OFF_PX = 2.6
"""Another disc's blurred edge reaches this far."""


@part
def shade(disc: Floats, surface: Floats, u: float, v: float, look: Floats) -> bool:
    """Look up a point of a sphere.

    Parameters
    ----------
    disc, surface
        Of a `sight.Look`, in one view.
    u, v
        Row and column from the centre in units of the radius.
    look
        Filled with disc and light: value, derivative to u, to v of the disc (0..2), of the light
        (3..5); u and v (6, 7).

    Returns
    -------
    False beyond the reach of the blur.
    """
    square = (u * u + v * v) * SQUARE_STEPS
    k = int(square)
    if k >= disc.shape[0] - 1:
        return False
    rise = disc[k + 1] - disc[k]
    look[0] = disc[k] + (square - k) * rise
    look[1], look[2] = 2.0 * SQUARE_STEPS * rise * u, 2.0 * SQUARE_STEPS * rise * v
    half = (surface.shape[0] - 1) * 0.5
    per_radius = half / SPAN
    a = min(max(u * per_radius + half, 0.0), 1.999999 * half)
    b = min(max(v * per_radius + half, 0.0), 1.999999 * half)
    i, j = int(a), int(b)
    a, b = a - i, b - j
    low, high = surface[i, j], surface[i + 1, j]
    across_low, across_high = surface[i, j + 1] - low, surface[i + 1, j + 1] - high
    low += b * across_low
    high += b * across_high
    look[3] = low + a * (high - low)
    look[4] = (high - low) * per_radius
    look[5] = (across_low + a * (across_high - across_low)) * per_radius
    look[6], look[7] = u, v
    return True


@part
def hidden(scene: Scene, row: int, column: int, others: Floats) -> bool:
    """Whether a pixel lies in a shadow, or in or close to another disc.

    Parameters
    ----------
    others
        Row, column and radius of each other disc, shape (others, 3).
    """
    return bool(scene.shadowed[row, column]) or covered(row, column, others)


@part
def covered(row: int, column: int, others: Floats) -> bool:
    """Whether a pixel lies in, or close to, one of the other discs (row, column, radius)."""
    for n in range(others.shape[0]):
        d_r, d_c = row - others[n, 0], column - others[n, 1]
        reach = others[n, 2] + KEEP_OFF_PX
        if d_r * d_r + d_c * d_c < reach * reach:
            return True
    return False


@part
def lit(look: Floats, light: Floats) -> float:
    """Return the light of the unmarked sphere at a point, its gain and slopes those of a frame."""
    return float(light[1] * look[3] + light[2] * look[6] + light[3] * look[7])


@part
def cover_at(canvas: Floats, i: int, j: int) -> Cover:
    """Return the cover of a pixel of a canvas and its derivatives to the disc's centre, 1/px."""
    return canvas[i, 0, j], canvas[i, 1, j], canvas[i, 2, j]


@part
def bend(look: Floats, cover: Cover, paint: Paint) -> float:
    """Return s^2 G . (grad M - M grad E / E) at a point."""
    light, _, radius, variance = paint
    least = max(look[0], LEAST_DISC)
    edge_u, edge_v = look[1] / least, look[2] / least
    square = edge_u * edge_u + edge_v * edge_v
    fall = 1.0 - (variance / (radius * radius) * square + math.sqrt(square))
    fall = min(max(fall - edge_u * look[6] - edge_v * look[7], LEAST_FALL), 1.0)
    cut = cover[0] / radius
    # The slopes are those to the centre: a pixel sees them with the other sign.
    along = (light[1] * look[4] + light[2]) * (cover[1] + cut * edge_u)
    across = (light[1] * look[5] + light[3]) * (cover[2] + cut * edge_v)
    return float(-(along + across) * variance / (radius * fall))


@part
def model_pixel(look: Floats, cover: Cover, behind: float, paint: Paint) -> float:
    """Return the grey level of a pixel.

    Parameters
    ----------
    look
        Of `shade`.
    behind
        Background.
    """
    light, darkness = paint[0], paint[1]
    left = look[0] - darkness * cover[0]
    shown = lit(look, light) * left - darkness * bend(look, cover, paint)
    return float((behind + light[0]) * (1.0 - look[0]) + shown)


@part
def pixel_row(
    look: Floats,
    drawn: tuple[Floats, int, int],
    behind: float,
    paint: Paint,
    row: Floats,
) -> float:
    """Fill the derivatives of a pixel to the unknowns and return its grey level.

    Parameters
    ----------
    look, behind
        As for `model_pixel`.
    drawn
        Canvas of the markers (`covers.cover_canvas`), row and column within it.
    row
        Filled, shape (UNKNOWNS,) or longer.
    """
    light, darkness, radius, _ = paint
    canvas, i, j = drawn
    back, own = behind + light[0], lit(look, light)
    left = look[0] - darkness * canvas[i, 0, j]
    shadow = own * darkness
    # The disc's own parts fall where the centre moves on; the cover's layers already do.
    edge = (back - own) / radius
    inner = left / radius
    row[0] = edge * look[1] - (light[1] * look[4] + light[2]) * inner - shadow * canvas[i, 1, j]
    row[1] = edge * look[2] - (light[1] * look[5] + light[3]) * inner - shadow * canvas[i, 2, j]
    row[2], row[3], row[4] = (
        -shadow * canvas[i, 3, j],
        -shadow * canvas[i, 4, j],
        -shadow * canvas[i, 5, j],
    )
    row[5] = 1.0 - look[0]
    row[6], row[7], row[8] = look[3] * left, look[6] * left, look[7] * left
    return float(back * row[5] + own * left - darkness * bend(look, cover_at(canvas, i, j), paint))


@part
def biweight(residual: float, limit: float) -> float:
    """Return Tukey's weight of a residual: 1 at 0, 0 from `limit` on."""
    x = residual / limit
    return 0.0 if abs(x) >= 1.0 else (1.0 - x * x) ** 2
