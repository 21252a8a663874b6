"""A ball that turns in place: the test that separates it from one that flies, and its positions.

Positions are shifts of its rim against the middle picture of the film, as its blotches move and its
rim does not. The brightness inside the rim is free in each sector, so that blotches at the rim do
not shift it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from analysis.arrays import Floats
from analysis.balls.discs.finding import DOUBTFUL, Disc, find_balls
from analysis.balls.films.film import Film, FilmHead, Picture
from analysis.balls.films.tone import light
from analysis.balls.seen.looks import CHANGED_SIGMAS, changes_of, rim_weights
from analysis.balls.seen.placing import Placed

Ints = NDArray[np.intp]
STAYING = 0.15
"""Of the frames looked at: a pixel that has changed in so many changes on its place."""
LEAST_STAYING, LEAST_WITHIN = 0.6, 0.85
"""Of all changes: those on such pixels, and those within the disc."""
LEAST_CHANGES = 50
"""Pixels of all frames together."""
OVER_RADII, OVER_PX = 1.05, 2.0
"""How far from a disc's centre a change may lie that is its own."""


def turning_ball(
    samples: Sequence[Picture], ground: Picture, noise: float, radii_px: tuple[float, float]
) -> Disc | None:
    """Return the disc on which nearly all changes of a film lie; None where there is none.

    Parameters
    ----------
    samples
        Frames of the whole film.
    ground
        Their middle.
    noise
        Standard deviation of a pixel that stands still.
    """
    counts = np.zeros(ground.shape[:2], dtype=np.intp)
    for sample in samples:
        counts += changes_of(sample, ground) > CHANGED_SIGMAS * noise
    staying = counts >= max(2.0, STAYING * len(samples))
    changes = int(counts.sum())
    if changes < LEAST_CHANGES or counts[staying].sum() < LEAST_STAYING * changes:
        return None
    rows, columns = np.nonzero(staying)
    middle = np.median(rows), np.median(columns)
    for disc in _discs_about(ground, (rows, columns), radii_px):
        reach = OVER_RADII * disc.radius + OVER_PX
        if np.hypot(middle[0] - disc.row, middle[1] - disc.column) > disc.radius:
            continue
        row, column = np.mgrid[: ground.shape[0], : ground.shape[1]]
        own = np.hypot(row - disc.row, column - disc.column) < reach
        if counts[own].sum() > LEAST_WITHIN * changes:
            return disc
    return None


def _discs_about(
    ground: Picture, changed: tuple[Ints, Ints], radii_px: tuple[float, float]
) -> list[Disc]:
    """Return discs of the middle picture where something changes on its place, as wide as it."""
    low = [int(np.percentile(each, 3)) for each in changed]
    high = [int(np.percentile(each, 97)) + 1 for each in changed]
    # Blotches change nearly all of a ball, but some part of it may be hidden.
    margin = max(high[0] - low[0], high[1] - low[1])
    top, left = (max(0, each - margin) for each in low)
    window = ground[top : high[0] + margin, left : high[1] + margin]
    radii = max(radii_px[0], 0.3 * margin), min(radii_px[1], 1.2 * margin)
    if radii[1] <= radii[0]:
        return []
    found = find_balls(window, radii, DOUBTFUL)
    return [replace(disc, row=disc.row + top, column=disc.column + left) for disc in found]


Flags = NDArray[np.bool_]

INSIDE_PX, OUTSIDE_PX = 3.0, 4.0
"""Of the rim: the band that is looked at."""
SECTOR_PX = 3.0
"""Of the rim, whose light is one number and a slope."""
BLURS_PX = (0.5, 0.65, 0.85, 1.1, 1.4, 1.8, 2.3)
LEAST_EXPLAINED = 0.8
"""Of a sector's light in the middle picture, by a rim; a holder hides the others."""
LEAST_SECTORS = 8
PASSES = 6
REJECTED_SIGMAS = 4.0
STEEP = 0.3
"""Of the largest change of light with a shift: pixels of the rim."""
DEVIATION = 1.4826
"""Standard deviation of normal errors, in medians of their sizes."""
LEAST_SPREAD = 1e-9
BLOTCHES = 12
"""Parts of a rim whose errors are independent: a blotch is about so wide."""
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
    fits = np.array(
        [
            _shift(rim, _of_channel(picture[window], film.head, weights)[tuple(rim.pixels)])
            for picture in film.pictures()
        ]
    )
    places = fits[:, :2] + (disc.row, disc.column)
    # What blotches at the rim do to a place lasts for many frames; its size is the film's scatter.
    sigmas = np.maximum(fits[:, 2:4], places.std(axis=0))
    left = fits[:, 4] * rim.pixels.shape[1]
    return Placed(np.arange(len(fits), dtype=np.intp), places, sigmas, fits[:, 4], left)


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


def _shift(rim: _Rim, shown: Floats) -> Floats:
    """Return the shift of a rim, its standard errors, and the mean square left; shape (5,)."""
    change = shown - rim.light
    at_rest = ndtr(rim.inward / rim.blur_px)
    weight = np.ones_like(change)
    shift: Floats = np.zeros(2)
    within: Floats = np.zeros(rim.number)
    for _ in range(PASSES):
        out = rim.normals @ shift
        inward = rim.inward + out
        cover = ndtr(inward / rim.blur_px)
        density = np.exp(-0.5 * (inward / rim.blur_px) ** 2) / (np.sqrt(2 * np.pi) * rim.blur_px)
        slopes = ((rim.steps + within[rim.sectors]) * density)[:, None] * rim.normals
        target = change - rim.steps * (cover - at_rest) + slopes @ shift
        free = np.stack([cover, cover * rim.inward], axis=1)
        parts = _without(np.column_stack([target, slopes]), free, weight, rim)
        aim, own = parts[:, 0], parts[:, 1:]
        matrix = (own * weight[:, None]).T @ own
        shift = np.asarray(
            np.linalg.solve(matrix + 1e-12 * np.eye(2), (own * weight[:, None]).T @ aim),
            dtype=np.float64,
        )
        residual = aim - own @ shift
        within = _levels(target - slopes @ shift, free, weight, rim)
        share = np.minimum(1.0, (residual / (REJECTED_SIGMAS * _spread(residual, own))) ** 2)
        weight = (1 - share) ** 2
    scores = np.zeros((BLOTCHES, 2))
    np.add.at(scores, rim.sectors * BLOTCHES // rim.number, (weight * residual)[:, None] * own)
    inverse = np.linalg.inv(matrix + 1e-12 * np.eye(2))
    covariance = inverse @ (scores.T @ scores) @ inverse
    left = float((weight * residual**2).sum() / max(weight.sum(), 1.0))
    return np.array([*shift, *np.sqrt(np.diag(covariance)), left])


def _spread(residual: Floats, own: Floats) -> Floats:
    """Return the standard deviation of what pixels leave: light's, and at the rim places' too.

    A shift that is not known yet leaves much at the rim, where it is to be seen, and there alone.
    """
    slope = np.hypot(*own.T)
    steep = slope > STEEP * slope.max()
    flat = DEVIATION * float(np.median(np.abs(residual[~steep]))) if not steep.all() else 0.0
    places = DEVIATION * float(np.median(np.abs(residual[steep]) / slope[steep]))
    return np.asarray(np.hypot(flat + LEAST_SPREAD, places * slope))


def _normal(free: Floats, weight: Floats, rim: _Rim) -> Floats:
    """Return each sector's inverse normal matrix of its light, shape (sectors, 2, 2)."""
    matrix = np.zeros((rim.number, 2, 2))
    np.add.at(matrix, rim.sectors, weight[:, None, None] * free[:, :, None] * free[:, None, :])
    return np.asarray(np.linalg.inv(matrix + 1e-9 * np.eye(2)), dtype=np.float64)


def _without(columns: Floats, free: Floats, weight: Floats, rim: _Rim) -> Floats:
    """Return columns less what each sector's light explains of them."""
    right = np.zeros((rim.number, 2, columns.shape[1]))
    np.add.at(right, rim.sectors, weight[:, None, None] * free[:, :, None] * columns[:, None, :])
    found = _normal(free, weight, rim) @ right
    return np.asarray(columns - np.einsum("ni,nij->nj", free, found[rim.sectors]), np.float64)


def _levels(rest: Floats, free: Floats, weight: Floats, rim: _Rim) -> Floats:
    """Return by how much the light within each sector's rim has changed."""
    right = np.zeros((rim.number, 2, 1))
    np.add.at(right, rim.sectors, (weight * rest)[:, None, None] * free[:, :, None])
    return np.asarray((_normal(free, weight, rim) @ right)[:, 0, 0])
