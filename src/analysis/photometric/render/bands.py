"""The pixels of one view, rows side by side in vectors: a frame's normal equations at speed.

The same model as in `residual`, one operation over many pixels at a time. A band has a fixed
length and its lanes follow each other in one array, so that the compiler can rule out overlap and
uses vector instructions; unsigned indices spare it the check for negative ones.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Singles
from analysis.compiled import part
from analysis.photometric.render.contour import LAYERS
from analysis.photometric.render.residual import (
    KEEP_OFF_PX,
    LEAST_DISC,
    LEAST_FALL,
    UNKNOWNS,
    Paint,
)
from analysis.photometric.render.sight import Equations, Sight
from analysis.photometric.render.surface import SPAN, SQUARE_STEPS

Ground = tuple[Floats, Singles, NDArray[np.bool_], Floats]
"""Background, grey levels and shadows of a frame, and the other discs in a view."""

BAND = 256
RESIDUAL, ROOT = np.uint64(UNKNOWNS * BAND), np.uint64((UNKNOWNS + 1) * BAND)
DISC, DISC_U, DISC_V, LIGHT, LIGHT_U, LIGHT_V, BEYOND, ACROSS, DOWN = (
    np.uint64((UNKNOWNS + 2 + k) * BAND) for k in range(9)
)
LANES = UNKNOWNS + 11
LANE = [np.uint64(k * BAND) for k in range(UNKNOWNS)]
L0, L1, L2, L3, L4, L5, L6, L7, L8 = LANE
ONE = np.uint64(1)


@part
def lay_along(
    rows: tuple[Floats, Floats, Singles],
    u: float,
    v: tuple[float, float],
    piece: tuple[Floats, int, int],
) -> None:
    """Lay a row of pixels into a band: place, covers, background and grey levels.

    Parameters
    ----------
    rows
        Covers, background and grey levels, shapes (LAYERS, width), (width,) and (width,).
    u, v
        Row from the centre in radii; column of the first pixel, and from pixel to pixel.
    piece
        The band, where the row starts in it, and its number of pixels.
    """
    covers, behind, grey = rows
    band, at, width = piece[0], np.uint64(piece[1]), np.uint64(piece[2])
    for layer in range(LAYERS):
        first = np.uint64(layer * BAND) + at
        for n in range(width):
            band[first + n] = covers[layer, n]
    for n in range(width):
        band[DOWN + at + n] = u
        band[ACROSS + at + n] = v[0] + v[1] * np.float64(n)
        band[L6 + at + n] = behind[n]
        band[RESIDUAL + at + n] = np.float64(grey[n])


@part
def look_up(disc: Floats, surface: Floats, band: Floats, count: int) -> None:
    """Look the first pixels of a band up (`residual.shade`).

    In three loops: only that which reads tables at places of its own has no vector instructions.
    """
    half = (surface.shape[0] - 1) * 0.5
    find_nodes(band, count, disc.shape[0] - 1.000001, half)
    read_nodes(disc, surface, band, count)
    blend_nodes(band, count, half / SPAN)


@part
def find_nodes(band: Floats, count: int, furthest: float, half: float) -> None:
    """Fill DISC and LIGHT with the nodes before each pixel, and what is left to the pixel beside.

    Parameters
    ----------
    furthest
        Of the disc's nodes.
    half
        Half side of the surface, nodes.
    """
    per_radius, widest, line = half / SPAN, 1.999999 * half, 2.0 * half + 1.0
    for n in range(np.uint64(count)):
        u, x = band[DOWN + n], band[ACROSS + n]
        square = min((u * u + x * x) * SQUARE_STEPS, furthest)
        # By way of 32 bits with a sign: several floats become such integers at once.
        node = np.float64(np.int32(square))
        band[DISC + n], band[DISC_U + n] = node, square - node
        a = min(max(u * per_radius + half, 0.0), widest)
        b = min(max(x * per_radius + half, 0.0), widest)
        i, j = np.float64(np.int32(a)), np.float64(np.int32(b))
        band[LIGHT + n] = i * line + j
        band[LIGHT_U + n], band[LIGHT_V + n] = a - i, b - j


@part
def read_nodes(disc: Floats, surface: Floats, band: Floats, count: int) -> None:
    """Put the values at the nodes about each pixel in the place of the nodes."""
    flat, line = surface.reshape(-1), np.uint64(surface.shape[1])
    for n in range(np.uint64(count)):
        node = np.uint64(np.int64(band[DISC + n]))
        band[DISC + n], band[DISC_V + n] = disc[node], disc[node + ONE]
        low = np.uint64(np.int64(band[LIGHT + n]))
        band[LIGHT + n], band[L7 + n] = flat[low], flat[low + ONE]
        band[L8 + n], band[BEYOND + n] = flat[low + line], flat[low + line + ONE]


@part
def blend_nodes(band: Floats, count: int, per_radius: float) -> None:
    """Fill disc and light, and their derivatives, between the values at the nodes.

    Parameters
    ----------
    per_radius
        Nodes of the surface.
    """
    for n in range(np.uint64(count)):
        start, share = band[DISC + n], band[DISC_U + n]
        rise = band[DISC_V + n] - start
        band[DISC + n] = start + share * rise
        band[DISC_U + n] = 2.0 * SQUARE_STEPS * rise * band[DOWN + n]
        band[DISC_V + n] = 2.0 * SQUARE_STEPS * rise * band[ACROSS + n]
        near, far, a, b = band[LIGHT + n], band[L8 + n], band[LIGHT_U + n], band[LIGHT_V + n]
        across, beyond = band[L7 + n] - near, band[BEYOND + n] - far
        near += b * across
        far += b * beyond
        band[LIGHT + n] = near + a * (far - near)
        band[LIGHT_U + n] = (far - near) * per_radius
        band[LIGHT_V + n] = (across + a * (beyond - across)) * per_radius


@part
def derive(paint: Paint, band: Floats, count: int) -> None:
    """Fill residuals and derivatives (`residual.pixel_row`) from what was looked up."""
    light, darkness, radius, variance = paint
    bent = darkness * variance / radius
    offset, gain, down, across = light[0], light[1], light[2], light[3]
    for n in range(np.uint64(count)):
        disc, u, x = band[DISC + n], band[DOWN + n], band[ACROSS + n]
        back = band[L6 + n] + offset
        own = gain * band[LIGHT + n] + down * u + across * x
        left = disc - darkness * band[L0 + n]
        shadow = own * darkness
        edge, inner = (back - own) / radius, left / radius
        moved_u = gain * band[LIGHT_U + n] + down
        moved_v = gain * band[LIGHT_V + n] + across
        to_row, to_column = shadow * band[L1 + n], shadow * band[L2 + n]
        least = max(disc, LEAST_DISC)
        edge_u, edge_v = band[DISC_U + n] / least, band[DISC_V + n] / least
        square = edge_u * edge_u + edge_v * edge_v
        fall = 1.0 - (variance / (radius * radius) * square + math.sqrt(square))
        fall = min(max(fall - edge_u * u - edge_v * x, LEAST_FALL), 1.0)
        cut = band[L0 + n] / radius
        along = moved_u * (band[L1 + n] + cut * edge_u)
        bend = bent / fall * (along + moved_v * (band[L2 + n] + cut * edge_v))
        band[L0 + n] = edge * band[DISC_U + n] - moved_u * inner - to_row
        band[L1 + n] = edge * band[DISC_V + n] - moved_v * inner - to_column
        band[L2 + n] = -shadow * band[L3 + n]
        band[L3 + n] = -shadow * band[L4 + n]
        band[L4 + n] = -shadow * band[L5 + n]
        band[L5 + n] = 1.0 - disc
        band[L6 + n] = band[LIGHT + n] * left
        band[L7 + n] = u * left
        band[L8 + n] = x * left
        band[RESIDUAL + n] -= back * (1.0 - disc) + own * left + bend


@part
def hide_along(
    shadowed: NDArray[np.bool_],
    row: int,
    first: int,
    others: Floats,
    piece: tuple[Floats, int, int],
) -> int:
    """Take a row's pixels in shadow, in or close to other discs out of the count; return how many.

    Parameters
    ----------
    shadowed
        Of the row's pixels here.
    row, first
        Of the frame: the row, and the column of its first pixel here.
    others
        Row, column and radius of each, shape (others, 3).
    """
    band, at, width = piece
    count = 0
    for k in range(width):
        band[np.uint64(at + k) + ROOT] = -1.0 if shadowed[k] else 1.0
        count += shadowed[k]
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
def ground_of(sight: Sight, view: int) -> Ground:
    """Return what the pixels of a view are laid with; a whole sight takes long to hand over."""
    scene = sight.scene
    return scene.background, scene.image, scene.shadowed, sight.others[view]


@part
def lay_piece(
    ground: Ground,
    covers: Floats,
    at: tuple[int, int, tuple[float, float, float]],
    piece: tuple[Floats, int, int],
) -> int:
    """Lay pixels of one row of a frame into a band; return how many of them count.

    Parameters
    ----------
    ground
        Of `ground_of`.
    covers
        As for `lay_along`.
    at
        Row and column of the first pixel; row, column and radius of the disc.
    piece
        As for `lay_along`.
    """
    (background, image, shadowed, others), (y, x, place), width = ground, at, piece[2]
    lines = (covers, background[y, x : x + width], image[y, x : x + width])
    across = ((x - place[1]) / place[2], 1.0 / place[2])
    lay_along(lines, (y - place[0]) / place[2], across, piece)
    return width - hide_along(shadowed[y, x : x + width], y, x, others, piece)


@part
def weigh(band: Floats, count: int, spread: tuple[float, float]) -> tuple[float, float]:
    """Weight a band's pixels (`residual.biweight`), and put each over its error.

    Parameters
    ----------
    spread
        Noise of a pixel, and the residual that counts no more, grey levels.

    Returns
    -------
    Weighted sum of squares over the second's square, and sum of weights.
    """
    filled = np.uint64(count)
    noise, widest = spread
    squares, weights = 0.0, 0.0
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
    return squares, weights


@part
def add_products(band: Floats, count: int, equations: Equations) -> None:
    """Add the products of all derivatives with each other and with the residual.

    Three lanes by three: nine sums and what they are of fit into a processor's registers.
    """
    for a in range(0, UNKNOWNS, 3):
        for b in range(0, a + 1, 3):
            add_nine(band, count, (a, b), equations.normal)
        add_three(band, count, a, equations.right)


@part
def add_nine(band: Floats, count: int, first: tuple[int, int], normal: Floats) -> None:
    """Add the products of three lanes of a band with three."""
    a, b = first
    a0, b0 = np.uint64(a * BAND), np.uint64(b * BAND)
    a1, a2, b1, b2 = a0 + L1, a0 + L2, b0 + L1, b0 + L2
    s00, s01, s02, s10, s11, s12, s20, s21, s22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for n in range(np.uint64(count)):
        x, y, z = band[a0 + n], band[a1 + n], band[a2 + n]
        u, v, w = band[b0 + n], band[b1 + n], band[b2 + n]
        s00, s01, s02 = s00 + x * u, s01 + x * v, s02 + x * w
        s10, s11, s12 = s10 + y * u, s11 + y * v, s12 + y * w
        s20, s21, s22 = s20 + z * u, s21 + z * v, s22 + z * w
    sums = ((s00, s01, s02), (s10, s11, s12), (s20, s21, s22))
    for i in range(3):
        for j in range(3):
            normal[a + i, b + j] += sums[i][j]


@part
def add_three(band: Floats, count: int, first: int, right: Floats) -> None:
    """Add the products of three lanes of a band with the residual."""
    a0 = np.uint64(first * BAND)
    a1, a2 = a0 + L1, a0 + L2
    s0, s1, s2 = 0.0, 0.0, 0.0
    for n in range(np.uint64(count)):
        off = band[RESIDUAL + n]
        s0, s1, s2 = s0 + band[a0 + n] * off, s1 + band[a1 + n] * off, s2 + band[a2 + n] * off
    right[first] += s0
    right[first + 1] += s1
    right[first + 2] += s2
