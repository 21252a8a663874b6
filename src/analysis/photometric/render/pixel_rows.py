"""A view's pixels as rows of derivatives: what learning adds up.

The columns are those to the frame's own unknowns (`residual`), to what all frames of a sphere
share, and the residual; each row is over its error. The pixels lie in bands (`bands`), so that
what they need is worked out in vectors.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.compiled import part
from analysis.photometric.learn.training_view import Viewed
from analysis.photometric.render.bands import (
    ACROSS,
    DISC,
    DISC_U,
    DISC_V,
    DOWN,
    L0,
    L1,
    L6,
    LIGHT,
    LIGHT_U,
    LIGHT_V,
    RESIDUAL,
    ROOT,
    derive,
    look_up,
    weigh,
)
from analysis.photometric.render.contour import ALPHA, LAYERS, RADIUS
from analysis.photometric.render.residual import LEAST_DISC, UNKNOWNS, hidden
from analysis.photometric.render.shading import HARMONICS, NUDGE, ORDER, RADIALS, STEPS_PER_RADIUS
from analysis.photometric.render.sight import Scene
from analysis.photometric.render.surface import SQUARE_STEPS

Places = NDArray[np.int64]

MARKERS_SHARE = 3
"""Behind the frame's own: darkness and angular radius of the markers, log radius of the sphere they
lie on.

Markers at different distances from the middle, and the same ones seen in both views, give the
radius without the limb, whose shading may pass for another radius.
"""
VIEW_SHARE = 4 + len(HARMONICS)
"""Then of each view: log radius of the limb, blur, log of the scale at which it is placed,
stretch of the markers' places along the rows, and the shading's coefficients: a wrong shading must
not bias what the markers determine."""
SCALE, STRETCH = 2, 3
"""Of these."""
OF_LIMB = UNKNOWNS + MARKERS_SHARE
OF_SHADING = OF_LIMB + 4
WIDTH = OF_SHADING + len(HARMONICS) + 1
"""Of a row, the residual last."""

COVER, TO_ROW, TO_ALPHA, TO_RADIUS, TO_BLUR, BEHIND = range(6)
"""Lanes beside a band: what `bands.derive` overwrites or does without."""
SHADOW, LEFT = range(6, 8)
"""Light that full cover takes from a pixel; share of the disc that the markers leave."""
BESIDE = 8

ANGULAR = np.array([RADIALS[j].angular for j, _ in HARMONICS])
SINE = np.array([sine for _, sine in HARMONICS])
HARMONIC = np.array([j for j, _ in HARMONICS])


@part
def pixels_of(drawn: Viewed, rows: Places) -> tuple[Places, Places]:
    """Return the rows and columns of a frame's pixels that a sphere and its blur reach.

    Parameters
    ----------
    rows
        First row of the view, and the first that is none of it.
    """
    place, corner = drawn.place, drawn.corner
    height, width = drawn.canvas.shape[0], drawn.canvas.shape[2]
    reach2 = (drawn.look[0].shape[0] - 1) / SQUARE_STEPS
    y, x = np.empty(height * width, np.int64), np.empty(height * width, np.int64)
    count = 0
    for i in range(max(rows[0] - corner[0], 0), min(height, rows[1] - corner[0])):
        u = (corner[0] + i - place[0]) / place[2]
        for j in range(width):
            v = (corner[1] + j - place[1]) / place[2]
            if u * u + v * v < reach2:
                y[count], x[count] = corner[0] + i, corner[1] + j
                count += 1
    return y[:count].copy(), x[:count].copy()


@part
def roughness(canvas: Floats, i: int, j: int) -> float:
    """Return the Laplacian of the cover, 1/px^2, from its values and slopes at five pixels.

    To fourth order (Hermite); 0 at the border of the canvas. Times the blur's standard deviation
    it is how the cover changes with that (heat equation).
    """
    if i < 1 or j < 1 or i + 1 >= canvas.shape[0] or j + 1 >= canvas.shape[2]:
        return 0.0
    along = canvas[i + 1, 0, j] - 2.0 * canvas[i, 0, j] + canvas[i - 1, 0, j]
    across = canvas[i, 0, j + 1] - 2.0 * canvas[i, 0, j] + canvas[i, 0, j - 1]
    slopes = canvas[i + 1, 1, j] - canvas[i - 1, 1, j] + canvas[i, 2, j + 1] - canvas[i, 2, j - 1]
    return float(2.0 * (along + across) + 0.5 * slopes)


@part
def add_squares(rows: Floats, products: Floats) -> None:
    """Add the products of all columns with each other."""
    own = np.dot(rows.T, rows)
    for a in range(own.shape[0]):
        for b in range(own.shape[1]):
            products[a, b] += own[a, b]


@part
def lay_pixels(
    scene: Scene, drawn: Viewed, others: Floats, pixels: tuple[Places, Places], lanes: Floats
) -> None:
    """Lay pixels into a band and beside it.

    Parameters
    ----------
    pixels
        Rows and columns, at most BAND.
    lanes
        The band's, then BESIDE more, shape (lanes, BAND).
    """
    image, background, canvas, place = scene.image, scene.background, drawn.canvas, drawn.place
    top, first = drawn.corner
    sigma, band, beside = math.sqrt(drawn.paint[3]), lanes.reshape(-1), lanes[-BESIDE:]
    for n in range(pixels[0].shape[0]):
        y, x = pixels[0][n], pixels[1][n]
        i, j = y - top, x - first
        for layer in range(LAYERS):
            lanes[layer, n] = canvas[i, layer, j]
        band[DOWN + np.uint64(n)] = (y - place[0]) / place[2]
        band[ACROSS + np.uint64(n)] = (x - place[1]) / place[2]
        band[L6 + np.uint64(n)] = background[y, x]
        band[RESIDUAL + np.uint64(n)] = np.float64(image[y, x])
        band[ROOT + np.uint64(n)] = -1.0 if hidden(scene, y, x, others) else 1.0
        beside[COVER, n], beside[TO_ROW, n] = canvas[i, 0, j], canvas[i, 1, j]
        beside[TO_ALPHA, n], beside[TO_RADIUS, n] = canvas[i, ALPHA, j], canvas[i, RADIUS, j]
        beside[TO_BLUR, n], beside[BEHIND, n] = sigma * roughness(canvas, i, j), background[y, x]


@part
def add_basis(profiles: Floats, gain: float, lanes: Floats, rows: Floats) -> None:
    """Fill the derivatives to the shading's coefficients: blurred harmonics times the light.

    Parameters
    ----------
    gain
        Of the light.
    lanes
        After `fill_shared`.
    rows
        Filled from OF_SHADING on.
    """
    turns, last = np.zeros((2, ORDER + 1)), np.float64(profiles.shape[0] - 2)
    band, beside, values = lanes.reshape(-1), lanes[-BESIDE:], np.zeros(profiles.shape[1])
    for n in range(rows.shape[0]):
        u, v = band[DOWN + np.uint64(n)], band[ACROSS + np.uint64(n)]
        light = gain * beside[LEFT, n] * band[ROOT + np.uint64(n)]
        rho = math.sqrt(u * u + v * v)
        at = min(rho * STEPS_PER_RADIUS, last)
        i = int(at)
        t = at - i
        c, s = (u / rho, v / rho) if rho > 1e-9 else (1.0, 0.0)
        turns[0, 0], turns[1, 0] = light, 0.0
        for m in range(1, ORDER + 1):
            turns[0, m] = turns[0, m - 1] * c - turns[1, m - 1] * s
            turns[1, m] = turns[1, m - 1] * c + turns[0, m - 1] * s
        low, high, own = profiles[i], profiles[i + 1], rows[n, OF_SHADING:]
        for j in range(values.size):
            values[j] = (1 - t) * low[j] + t * high[j]
        for h in range(HARMONIC.shape[0]):
            own[h] = values[HARMONIC[h]] * turns[SINE[h], ANGULAR[h]]


@part
def fill_shared(drawn: Viewed, lanes: Floats, wider: Floats, rows: Floats) -> None:
    """Fill the columns behind the frame's own, but those of the shading.

    Parameters
    ----------
    lanes, wider
        A band whose residuals are weighed, with what lies beside it, and disc and light by the
        wider blur.
    rows
        Shape (pixels, WIDTH).
    """
    light, dark, radius, _ = drawn.paint
    offset, gain, down, across = light[0], light[1], light[2], light[3]
    band, beside, off_r, off_c = lanes.reshape(-1), lanes[-BESIDE:], drawn.off[0], drawn.off[1]
    for k in range(rows.shape[0]):
        n = np.uint64(k)
        u, x, disc, root = band[DOWN + n], band[ACROSS + n], band[DISC + n], band[ROOT + n]
        own, cover = gain * band[LIGHT + n] + down * u + across * x, beside[COVER, k]
        above, shadow = own - beside[BEHIND, k] - offset, own * dark * root
        left = disc - dark * cover
        to_u, to_v = gain * band[LIGHT_U + n] + down, gain * band[LIGHT_V + n] + across
        edge = band[DISC_U + n] * u + band[DISC_V + n] * x
        dimmer, softer = wider[DISC + n] - disc, gain * (wider[LIGHT + n] - band[LIGHT + n])
        rows[k, UNKNOWNS] = -own * cover * root
        rows[k, UNKNOWNS + 1] = -shadow * beside[TO_ALPHA, k]
        rows[k, UNKNOWNS + 2] = -shadow * beside[TO_RADIUS, k]
        rows[k, OF_LIMB] = -root * (above * edge + left * (to_u * u + to_v * x))
        softer = root * (above * dimmer + left * softer) / NUDGE
        rows[k, OF_LIMB + 1] = softer - shadow * beside[TO_BLUR, k]
        rows[k, OF_LIMB + SCALE] = band[L0 + n] * off_r + band[L1 + n] * off_c
        rows[k, OF_LIMB + STRETCH] = -shadow * beside[TO_ROW, k] * u * radius
        beside[SHADOW, k] = shadow
        beside[LEFT, k] = max(1.0 - dark * cover / max(disc, LEAST_DISC), 0.0)


@part
def fill_rows(
    scene: Scene,
    drawn: Viewed,
    limit: float,
    room: tuple[Floats, Floats],
    rows: Floats,
) -> None:
    """Fill the rows of the pixels that lie in a band (`lay_pixels`).

    Parameters
    ----------
    limit
        Residual that counts no more, in units of the noise.
    room
        The lanes, and room for another band.
    rows
        Filled, shape (pixels, WIDTH).
    """
    lanes, wider = room
    band, count, size = lanes.reshape(-1), rows.shape[0], np.uint64(rows.shape[0])
    for n in range(size):
        wider[DOWN + n], wider[ACROSS + n] = band[DOWN + n], band[ACROSS + n]
    look_up(drawn.look[0], drawn.look[1], band, count)
    look_up(drawn.wider[0], drawn.wider[1], wider, count)
    derive(drawn.paint, band, count)
    weigh(band, count, (scene.noise, limit * scene.noise))
    fill_shared(drawn, lanes, wider, rows)
    add_basis(drawn.profiles, drawn.paint[0][1], lanes, rows)
    for k in range(count):
        for a in range(UNKNOWNS):
            rows[k, a] = lanes[a, k]
        rows[k, WIDTH - 1] = lanes[UNKNOWNS, k]
