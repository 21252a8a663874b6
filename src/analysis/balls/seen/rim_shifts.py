"""Positions of a ball that turns in place: shifts of its rim.

They are measured against the middle picture of the film, as the ball's blotches move and its rim
does not. Each sector of the rim has a shift of its own beside a free light within, and the less of
a say the more its light has changed: a blotch that enters at the rim is a thin line first, which
looks like a shift. What a sector's light in the frames before and after adds to its shift is fitted
and taken off.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d
from scipy.special import ndtr

from analysis.arrays import Floats
from analysis.balls.discs.disc import Disc
from analysis.balls.films.film import Film, FilmHead, Picture
from analysis.balls.films.tone import light
from analysis.balls.seen.looks import rim_weights
from analysis.balls.seen.placing import Placed

Ints = NDArray[np.intp]
Flags = NDArray[np.bool_]
INSIDE_PX, OUTSIDE_PX = 3.0, 4.0
"""Of the rim: the band that is looked at."""
SECTOR_PX = 3.0
"""Of the rim, whose light is one number and a slope."""
BLURS_PX = (0.5, 0.65, 0.85, 1.1, 1.4, 1.8, 2.3)
LEAST_EXPLAINED = 0.8
"""Of a sector's light in the middle picture, by a rim; a holder hides the others."""
LEAST_SECTORS = 8
LEAST_PIXELS = 8
"""Of a sector, for a shift, a light and its slope."""
STEPS = 3
"""Passes over a sector's step, which the light within changes."""
AT_ONCE = 256
"""Frames whose pixels are held together."""
EXACT_PX, OF_NOISE, OF_LIGHT, OF_SLOPE, OF_BLOTCH = 0.01, 0.76, 0.2, 0.8, 0.3
"""Errors of a sector's shift: px; and shares of what noise gives, of changes of light and slope (of
the step), and of the largest change of light in the frames about, those by which drawn films are
off (python -m benchmarks.balls.turning)."""
BLOTCH_FRAMES, MOST_CHANGE = 15, 2.0
"""Frames before and after one in which the light of a sector of the rim is compared, as a blotch
there lasts; and the largest change of that light, in steps: larger ones count as that."""
LEAST_STEP = 0.3
"""In noise: what is added to a step that light is measured by."""
FREEDOM = 3.0
"""Of Student's t of a sector's shift: blotches are outliers."""
PASSES, AGAIN = 12, 3
"""Of the fit of all shifts, and of what sectors have by themselves."""
LAGS, MOST_LIGHT = (-12, -8, -5, -3, -1, 0, 1, 3, 5, 8, 12), 3.0
"""Frames about one whose light says what a sector of the rim is off by, and the largest change of
light that counts, in steps."""
RING_IN, RING_OUT = (0.6, 0.92), (1.08, 1.3)
"""Radii of the light within and without that choose the channel."""


@dataclass(frozen=True, slots=True, eq=False)
class _Rim:
    """Pixels about a rim in the middle picture.

    Attributes
    ----------
    pixels
        Rows and columns in the window, shape (2, N).
    inward
        Distance from the rim, inside positive, px, shape (N,).
    normals
        Outward directions (row, column), shape (N, 2).
    sectors
        Number of each pixel's sector, shape (N,), and how many there are.
    blur_px
        Of the rim.
    light, steps
        Middle light of each pixel, and the step over the rim of each pixel's sector.
    """

    pixels: Ints
    inward: Floats
    normals: Floats
    sectors: Ints
    number: int
    blur_px: float
    light: Floats
    steps: Floats


def place_turning(film: Film, disc: Disc, ground: Picture) -> Placed | None:
    """Return the places of a ball that turns on its place, of all frames; None without a rim.

    Errors are at least the scatter of the whole film: a ball that also sways has too large ones.

    Parameters
    ----------
    disc
        In the middle picture.
    ground
        The middle picture.
    """
    reach = int(np.ceil(max(RING_OUT[1] * disc.radius, disc.radius + OUTSIDE_PX))) + 2
    top, left = max(0, int(disc.row) - reach), max(0, int(disc.column) - reach)
    window = slice(top, int(disc.row) + reach + 1), slice(left, int(disc.column) + reach + 1)
    weights = _weights(ground[window], (disc.row - top, disc.column - left), disc, film.head)
    still = _of_channel(ground[window], film.head, weights)
    rim = _rim(still, (disc.row - top, disc.column - left), disc.radius)
    if rim is None:
        return None
    sectors = _sectors_of(rim)
    if len(sectors) < LEAST_SECTORS:
        return None
    lights: list[Floats] = []
    seen: list[Floats] = []
    for picture in film.pictures():
        lights.append(_of_channel(picture[window], film.head, weights)[tuple(rim.pixels)])
        if len(lights) == AT_ONCE:
            seen.append(_shifts(sectors, np.array(lights) - rim.light))
            lights = []
    if lights:
        seen.append(_shifts(sectors, np.array(lights) - rim.light))
    every = np.concatenate(seen, axis=1)
    steps = np.array([sector.step for sector in sectors])
    normals = np.array([sector.normal for sector in sectors])
    shifts, errors = _together(normals, every[0], *_errors(every, steps))
    places = shifts + np.array([disc.row, disc.column])
    # What blotches at the rim do to a place lasts for many frames; its size is the film's scatter.
    sigmas = np.maximum(errors, places.std(axis=0))
    frames, misfits = np.arange(len(places), dtype=np.intp), every[4].mean(axis=1)
    left, none = misfits * rim.pixels.shape[1], np.zeros(len(frames))
    return Placed(frames, places, sigmas, misfits, left, none)


def _of_channel(picture: Picture, head: FilmHead, weights: Floats) -> Floats:
    return np.asarray(light(picture, head) @ weights, dtype=np.float64)


def _weights(window: Picture, centre: tuple[float, float], disc: Disc, head: FilmHead) -> Floats:
    """Return weights of the channels that tell the ball from what is about it."""
    row, column = np.ogrid[: window.shape[0], : window.shape[1]]
    away = np.hypot(row - centre[0], column - centre[1]) / disc.radius
    inside, outside = (
        light(window[(away > low) & (away < high)], head) for low, high in (RING_IN, RING_OUT)
    )
    # Of a coded film brightness at any size, as of the smallest: coded colours are too coarse here.
    return rim_weights(inside, outside, head, 0.0)


def _rim(still: Floats, centre: tuple[float, float], radius: float) -> _Rim | None:
    """Return the pixels about a rim and what the middle picture shows there."""
    row, column = np.mgrid[: still.shape[0], : still.shape[1]]
    down, right = row - centre[0], column - centre[1]
    away = np.hypot(down, right)
    pixels = np.array(np.nonzero((away > radius - INSIDE_PX) & (away < radius + OUTSIDE_PX)))
    chosen = tuple(pixels)
    angles = np.arctan2(down[chosen], right[chosen])
    number = max(LEAST_SECTORS, round(2 * np.pi * radius / SECTOR_PX))
    sectors = np.floor((angles + np.pi) / (2 * np.pi) * number).astype(np.intp) % number
    inward, own = radius - away[chosen], still[chosen]
    fits = [_steps(own, inward, (sectors, number), blur) for blur in BLURS_PX]
    left = [float(each[1][each[2]].sum() / max(1, each[2].sum())) for each in fits]
    best = int(np.argmin(left))
    steps, _, seen = fits[best]
    if seen.sum() < LEAST_SECTORS:
        return None
    use = seen[sectors]
    normals = np.stack([np.sin(angles), np.cos(angles)], axis=1)
    return _Rim(
        pixels[:, use],
        inward[use],
        normals[use],
        sectors[use],
        number,
        BLURS_PX[best],
        own[use],
        steps[sectors[use]],
    )


def _steps(
    own: Floats, inward: Floats, sectors: tuple[Ints, int], blur: float
) -> tuple[Floats, Floats, Flags]:
    """Return each sector's step over the rim, what it leaves, and whether a rim explains it."""
    numbers, count = sectors
    steps, left, seen = np.zeros(count), np.zeros(count), np.zeros(count, dtype=np.bool_)
    cover = ndtr(inward / blur)
    design = np.stack([np.ones_like(cover), cover, cover * inward, (1 - cover) * inward], axis=1)
    for k in range(count):
        here = numbers == k
        if here.sum() < 2 * design.shape[1]:
            continue
        light_there = own[here]
        found = np.linalg.lstsq(design[here], light_there, rcond=None)[0]
        residual = light_there - design[here] @ found
        whole = float(((light_there - light_there.mean()) ** 2).sum())
        steps[k], left[k] = found[1], float(residual @ residual)
        seen[k] = left[k] < (1 - LEAST_EXPLAINED) * whole
    return steps, left, seen


@dataclass(frozen=True, slots=True, eq=False)
class _Sector:
    """A sector of the rim.

    Attributes
    ----------
    pixels
        Which of the rim's pixels are its own, shape (N,).
    light
        What a change of the light within and of its slope do to them, shape (N, 2).
    density
        What a shift of a step of one does to them, 1/px, shape (N,).
    step, normal
        Of the middle picture; outward direction (row, column), shape (2,).
    """

    pixels: Ints
    light: Floats
    density: Floats
    step: float
    normal: Floats


def _sectors_of(rim: _Rim) -> list[_Sector]:
    found = []
    for k in range(rim.number):
        own = np.flatnonzero(rim.sectors == k)
        if len(own) < LEAST_PIXELS:
            continue
        inward, normal = rim.inward[own], rim.normals[own].mean(axis=0)
        cover = ndtr(inward / rim.blur_px)
        density = np.exp(-0.5 * (inward / rim.blur_px) ** 2) / (np.sqrt(2 * np.pi) * rim.blur_px)
        light_within = np.stack([cover, cover * inward], axis=1)
        normal = normal / np.hypot(*normal)
        found.append(_Sector(own, light_within, density, float(rim.steps[own[0]]), normal))
    return found


def _shifts(sectors: Sequence[_Sector], changes: Floats) -> Floats:
    """Return what each sector shows in each frame, shape (5, frames, sectors).

    Outward shift in px, its error for noise of one, change of the light within and of its slope,
    and the mean square of what is left.

    Parameters
    ----------
    changes
        Of the light of the rim's pixels, shape (frames, N).
    """
    found = np.zeros((5, len(changes), len(sectors)))
    for k, sector in enumerate(sectors):
        change = changes[:, sector.pixels]
        level = np.zeros(len(changes))
        for step in range(STEPS):
            slopes = (sector.step + level)[:, None] * sector.density
            design = np.broadcast_to(sector.light, (*change.shape, 2))
            design = np.concatenate([design, slopes[..., None]], axis=2)
            turned = design.transpose(0, 2, 1)
            inverse = np.linalg.inv(turned @ design + 1e-6 * np.eye(3))
            fit = (inverse @ (turned @ change[..., None]))[..., 0]
            # Half of the way at first: shift and light trade places.
            level = fit[:, 0] if step == STEPS - 1 else 0.5 * (level + fit[:, 0])
        left = change - (design @ fit[..., None])[..., 0]
        square = (left**2).sum(axis=1) / (len(sector.pixels) - 3)
        found[:, :, k] = fit[:, 2], np.sqrt(inverse[:, 2, 2]), fit[:, 0], fit[:, 1], square
    return found


def _errors(seen: Floats, steps: Floats) -> tuple[Floats, Floats]:
    """Return errors of the shifts of `_shifts`, px, and changes of light in steps.

    Each of shape (frames, sectors).
    """
    _, of_noise, level, slope, left = seen
    noise = float(np.median(np.sqrt(left)))
    step = np.abs(steps + level) + LEAST_STEP * noise + 1e-9
    changed = np.minimum(MOST_CHANGE, np.abs(level) / step)
    blotch = maximum_filter1d(changed, 2 * BLOTCH_FRAMES + 1, axis=0, mode="nearest")
    square = EXACT_PX**2 + (OF_NOISE * noise * of_noise) ** 2 + (OF_BLOTCH * blotch) ** 2
    square += (OF_LIGHT * level / step) ** 2 + (OF_SLOPE * slope / step) ** 2
    return np.sqrt(square), level / (np.abs(steps) + LEAST_STEP * noise + 1e-9)


def _together(
    normals: Floats, offsets: Floats, errors: Floats, lights: Floats
) -> tuple[Floats, Floats]:
    """Return the shift of the whole rim in each frame, and its errors, each shape (frames, 2).

    What a sector is off by in all frames is the middle picture's, which holds its blotches too.
    What it is off by as its light changes about the frame is its blotches'.
    """
    terms = _lagged(lights)
    own = np.median(offsets, axis=0)
    by_light = np.zeros_like(offsets)
    shifts = np.zeros((len(offsets), 2))
    for _ in range(1 + AGAIN):
        for _ in range(PASSES):
            left = offsets - own - by_light - shifts @ normals.T
            weight = (FREEDOM + 1) / (FREEDOM * errors**2 + left**2)
            matrix = np.einsum("ts,si,sj->tij", weight, normals, normals) + 1e-9 * np.eye(2)
            right = np.einsum("ts,si,ts->ti", weight, normals, offsets - own - by_light)
            shifts = np.linalg.solve(matrix, right[..., None])[..., 0]
        left = offsets - shifts @ normals.T
        own = (weight * (left - by_light)).sum(axis=0) / weight.sum(axis=0)
        by_light = _by_light(terms, left - own, weight)
    return shifts, np.sqrt(np.diagonal(np.linalg.inv(matrix), axis1=1, axis2=2))


def _lagged(lights: Floats) -> Floats:
    """Return each sector's light at `LAGS` about each frame, shape (sectors, frames, lags).

    Without what all frames share, and of a size of one.
    """
    held = np.clip(lights, -MOST_LIGHT, MOST_LIGHT)
    frames = np.arange(len(held))
    about = [held[np.clip(frames + lag, 0, len(held) - 1)] for lag in LAGS]
    terms = np.stack(about, axis=-1).transpose(1, 0, 2)
    terms = terms - terms.mean(axis=1, keepdims=True)
    return np.asarray(terms / (terms.std() + 1e-12))


def _by_light(terms: Floats, left: Floats, weight: Floats) -> Floats:
    """Return what the light about each frame says of shifts that are left, px, (frames, sectors).

    Each sector has factors of its own, about zero by its own error.
    """
    weighted = terms * weight.T[..., None]
    least = np.median(weight, axis=0)[:, None, None] * np.eye(terms.shape[2])
    matrix = terms.transpose(0, 2, 1) @ weighted + least
    right = np.einsum("stk,ts->sk", weighted, left)
    factors = np.linalg.solve(matrix, right[..., None])
    return np.asarray((terms @ factors)[..., 0].T)
