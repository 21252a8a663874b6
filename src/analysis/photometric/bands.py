"""The pixels of one view, rows side by side in vectors: a frame's normal equations at speed.

The same model as in `residual`, one operation over many pixels at a time. A band has a fixed
length and its lanes follow each other in one array, so that the compiler knows that they are
apart and uses vector instructions; unsigned indices spare it the check for negative ones.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.photometric.compiled import part
from analysis.photometric.contour import LAYERS
from analysis.photometric.covers import cover_canvas
from analysis.photometric.residual import KEEP_OFF_PX, UNKNOWNS
from analysis.photometric.sight import Equations, Sight, Stance
from analysis.photometric.surface import SPAN, SQUARE_STEPS

Floats = NDArray[np.float64]

BAND = 512
RESIDUAL, ROOT = np.uint64(UNKNOWNS * BAND), np.uint64((UNKNOWNS + 1) * BAND)
DISC, DISC_U, DISC_V, LIGHT, LIGHT_U, LIGHT_V, ACROSS = (
    np.uint64((UNKNOWNS + 2 + k) * BAND) for k in range(7)
)
LANES = UNKNOWNS + 9
LANE = [np.uint64(k * BAND) for k in range(UNKNOWNS)]
L0, L1, L2, L3, L4, L5, L6, L7, L8 = LANE
ONE = np.uint64(1)


@part
def look_along(
    disc: Floats, surface: Floats, u: float, v: tuple[float, float], piece: tuple[Floats, int, int]
) -> None:
    """Look a row of pixels up (`residual.shade`).

    Parameters
    ----------
    v
        Of the first pixel, and from pixel to pixel.
    piece
        The band, where the row starts in it, and its number of pixels.
    """
    band, at, width = piece[0], np.uint64(piece[1]), np.uint64(piece[2])
    half = (surface.shape[0] - 1) * 0.5
    per_radius = half / SPAN
    a = min(max(u * per_radius + half, 0.0), 1.999999 * half)
    i = int(a)
    a -= i
    low, high = surface[i], surface[i + 1]
    furthest = disc.shape[0] - 1.000001
    for n in range(width):
        x = v[0] + v[1] * np.float64(n)
        square = min((u * u + x * x) * SQUARE_STEPS, furthest)
        k = np.uint64(square)
        start = disc[k]
        rise = disc[k + ONE] - start
        band[DISC + at + n] = start + (square - np.float64(k)) * rise
        band[DISC_U + at + n] = 2.0 * SQUARE_STEPS * rise * u
        band[DISC_V + at + n] = 2.0 * SQUARE_STEPS * rise * x
        b = min(max(x * per_radius + half, 0.0), 1.999999 * half)
        j = np.uint64(b)
        b -= np.float64(j)
        near, far = low[j], high[j]
        across, beyond = low[j + ONE] - near, high[j + ONE] - far
        near += b * across
        far += b * beyond
        band[LIGHT + at + n] = near + a * (far - near)
        band[LIGHT_U + at + n] = (far - near) * per_radius
        band[LIGHT_V + at + n] = (across + a * (beyond - across)) * per_radius
        band[ACROSS + at + n] = x


@part
def copy_along(
    covers: Floats, behind: Floats, grey: NDArray[np.uint8], piece: tuple[Floats, int, int]
) -> None:
    """Copy a row's covers, background and grey levels to where its derivatives will stand.

    Parameters
    ----------
    covers, behind, grey
        Shapes (LAYERS, width), (width,) and (width,).
    """
    band, at, width = piece[0], np.uint64(piece[1]), np.uint64(piece[2])
    for layer in range(LAYERS):
        first = np.uint64(layer * BAND) + at
        for n in range(width):
            band[first + n] = covers[layer, n]
    for n in range(width):
        band[L6 + at + n] = behind[n]
    for n in range(width):
        band[RESIDUAL + at + n] = np.float64(grey[n])


@part
def derive_along(
    paint: tuple[Floats, float, float], u: float, piece: tuple[Floats, int, int]
) -> None:
    """Fill a row's residuals and derivatives (`residual.pixel_row`) from what was looked up.

    Parameters
    ----------
    paint
        Light of the view, darkness of the markers, radius of the disc in pixels.
    u
        Of the row.
    """
    band, at, width = piece[0], np.uint64(piece[1]), np.uint64(piece[2])
    light, darkness, radius = paint
    offset, gain, down, across = light[0], light[1], light[2], light[3]
    for n in range(width):
        disc, x = band[DISC + at + n], band[ACROSS + at + n]
        back = band[L6 + at + n] + offset
        own = gain * band[LIGHT + at + n] + down * u + across * x
        left = disc - darkness * band[L0 + at + n]
        shadow = own * darkness
        edge, inner = (back - own) / radius, left / radius
        moved_u = gain * band[LIGHT_U + at + n] + down
        moved_v = gain * band[LIGHT_V + at + n] + across
        to_row, to_column = shadow * band[L1 + at + n], shadow * band[L2 + at + n]
        band[L0 + at + n] = edge * band[DISC_U + at + n] - moved_u * inner - to_row
        band[L1 + at + n] = edge * band[DISC_V + at + n] - moved_v * inner - to_column
        band[L2 + at + n] = -shadow * band[L3 + at + n]
        band[L3 + at + n] = -shadow * band[L4 + at + n]
        band[L4 + at + n] = -shadow * band[L5 + at + n]
        band[L5 + at + n] = 1.0 - disc
        band[L6 + at + n] = band[LIGHT + at + n] * left
        band[L7 + at + n] = u * left
        band[L8 + at + n] = x * left
        band[RESIDUAL + at + n] -= back * (1.0 - disc) + own * left


@part
def hide_along(row: int, first: int, others: Floats, piece: tuple[Floats, int, int]) -> int:
    """Take a row's pixels in or close to other discs out of the count; return how many.

    Parameters
    ----------
    row, first
        Of the frame: the row, and the column of its first pixel here.
    others
        Row, column and radius of each, shape (others, 3).
    """
    band, at, width = piece
    count = 0
    for k in range(width):
        band[np.uint64(at + k) + ROOT] = 1.0
    for n in range(others.shape[0]):
        reach, off = others[n, 2] + KEEP_OFF_PX, row - others[n, 0]
        if abs(off) >= reach:
            continue
        half = math.sqrt(reach * reach - off * off)
        begin = max(math.floor(others[n, 1] - half) + 1 - first, 0)
        end = min(math.ceil(others[n, 1] + half) - first, width)
        for k in range(begin, end):
            place = np.uint64(at + k) + ROOT
            if band[place] >= 0.0:
                count += 1
            band[place] = -1.0
    return count


@part
def weigh(band: Floats, count: int, noise: float, limit: float) -> tuple[float, float]:
    """Weight a band's pixels (`residual.biweight`), and put each over its error.

    Returns
    -------
    Weighted sum of squares over the noise's variance, and sum of weights.
    """
    filled = np.uint64(count)
    squares, weights, widest = 0.0, 0.0, limit * noise
    for n in range(filled):
        x = band[RESIDUAL + n] / widest
        root = max(1.0 - x * x, 0.0) if band[ROOT + n] > 0.0 else 0.0
        squares += (root * x) ** 2
        weights += root * root
        band[ROOT + n] = root / noise
    for lane in range(UNKNOWNS + 1):
        first = np.uint64(lane * BAND)
        for n in range(filled):
            band[first + n] *= band[ROOT + n]
        for n in range(filled, np.uint64(BAND)):
            band[first + n] = 0.0
    return squares * limit * limit, weights


@part
def add_products(band: Floats, equations: Equations) -> None:
    """Add the products of all derivatives with each other and with the residual."""
    lanes = band[: (UNKNOWNS + 1) * BAND].reshape(UNKNOWNS + 1, BAND)
    products = np.dot(lanes, lanes.T)
    for a in range(UNKNOWNS):
        for b in range(a + 1):
            equations.normal[a, b] += products[a, b]
        equations.right[a] += products[a, UNKNOWNS]


@part
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
    scene, disc, surface = sight.scene, sight.look.discs[view], sight.look.surfaces[view]
    canvas, corner, place = cover_canvas(sight, stance, view)
    rows, reach2 = sight.optics.rows[view], (disc.shape[0] - 1) / SQUARE_STEPS
    band = np.empty(LANES * BAND)
    squares, weights, count, filled = 0.0, 0.0, 0, 0
    first_row = max(rows[0] - corner[0], 0)
    for i in range(first_row, min(canvas.shape[0], rows[1] - corner[0])):
        u = (corner[0] + i - place[0]) / place[2]
        if u * u >= reach2:
            continue
        half, middle = math.sqrt(reach2 - u * u) * place[2], place[1] - corner[1]
        start = max(math.ceil(middle - half), 0)
        end = min(math.floor(middle + half) + 1, canvas.shape[2])
        while start < end:
            width = min(end - start, BAND)
            if filled + width > BAND:
                part = weigh(band, filled, scene.noise, limit)
                squares, weights = squares + part[0], weights + part[1]
                add_products(band, equations)
                filled = 0
            x, y = corner[1] + start, corner[0] + i
            piece = (band, filled, width)
            look_along(disc, surface, u, ((x - place[1]) / place[2], 1.0 / place[2]), piece)
            copy_along(
                canvas[i, :, start : start + width],
                scene.background[y, x : x + width],
                scene.image[y, x : x + width],
                piece,
            )
            derive_along((stance.lights[view], sight.look.darkness, place[2]), u, piece)
            count += width - hide_along(y, x, sight.others[view], piece)
            filled += width
            start += width
    part = weigh(band, filled, scene.noise, limit)
    add_products(band, equations)
    return squares + part[0], weights + part[1], count
