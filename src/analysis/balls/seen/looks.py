"""How a film's ball looks: its radius, its light, and the channel in which its rim is measured."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis import threads
from analysis.arrays import Floats
from analysis.balls.discs.disc import Disc
from analysis.balls.discs.finding import find_balls
from analysis.balls.films.film import FilmHead, Picture
from analysis.balls.films.tone import BRIGHTNESS, light

Singles = NDArray[np.float32]

LEAST_RADIUS_PX = 4.0
MOST_SHARE = 0.35
"""Largest radius, of the picture's smaller side."""
LEAST_SHARE = 0.006
"""Smallest radius, of the picture's smaller side."""
MOST_SEARCHED, LEAST_SEARCHED = 16, 8
"""Frames in which discs are sought before the ball is known, those with the least motion first."""
MOST_SOUGHT_PX = 3e6
"""Of what moves in them: what is enough once so many frames at least were searched."""
LEAST_CHANGED = 20
"""Pixels of a part of the picture that has changed."""
ALIKE = 0.12
"""Discs whose radii differ by less than this share may be one ball's."""
LEAST_ALARMS = -5.0
LIGHT_SIGMA = 0.04
"""Relative error of a radius that a smooth shading is fitted with."""
OUTLINE_SIGMA = 0.025
"""The same of the outline of a ball with patches."""
LEAST_BRIGHTNESS = 0.2
"""Of the largest difference of a channel, where brightness is taken for the rim."""
RIM_SIGMA = 0.007
"""Relative error of a rim's radius where half of the ball is as dark as the ground."""
ONE_SIDED_SIGMA = 0.015
"""Relative error of a radius whose places lean by as much as it changes: light from one side leaves
the other limb as dark as the ground, and what is taken for the rim ends before it."""
CODEC_PX = 0.4
"""Error of a rim's radius where a codec, or a telephone's sharpening, has been at it."""
CODED_RADIUS_PX = 13.0
"""Larger balls of compressed films are fitted in pixels that are whole multiples of the film's."""
CODEC_LEVELS, MOST_CODEC_NOISE = 2.0, 0.3
"""Error of a channel's light, and what of it may be left of a ball's contrast of 1."""
LEAST_PATCHES = 0.35
"""What a smooth shading leaves of a ball's light, over the difference from its ground: patches."""
INSIDE_RADII = 0.85
"""Of a disc: pixels that tell the ball's own light."""
SHADOW_WEIGHT = 25.0
"""By how much the ground's own colour counts as noise: shadows dim it and drop out."""


@dataclass(frozen=True, slots=True, eq=False)
class Looks:
    """A ball as a film shows it.

    Attributes
    ----------
    radius_px, radius_sigma_px
        Of its rim, and the standard error of it.
    shading
        The ball's own values, a smooth function of the place on its disc, shape (TERMS, channels):
        what `shaded` multiplies.
    spread
        Covariance of what it leaves of the ball's values, shape (channels, channels).
    light_weights
        Of the channels' light, so that ball less ground is 1 on average, shape (channels,).
    seen
        Frame and disc of each sighting that taught this.
    patches
        What the shading leaves of the ball's light, rms, over that of ball less ground.
    """

    radius_px: float
    radius_sigma_px: float
    shading: Floats
    spread: Floats
    light_weights: Floats
    seen: tuple[tuple[int, Disc], ...]
    patches: float = 0.0

    @property
    def patched(self) -> bool:
        """Return whether it shows other patches in each frame."""
        return self.patches > LEAST_PATCHES

    def with_radius(self, radius_px: float) -> Looks:
        """Return the same with a radius that light and not the rim has told."""
        sigma = OUTLINE_SIGMA if self.patched else LIGHT_SIGMA
        return replace(self, radius_px=radius_px, radius_sigma_px=sigma * radius_px)

    def leaning(self, leans_px: Floats) -> Looks:
        """Return the same with the radius's error of a ball that is seen by one side of its rim.

        Parameters
        ----------
        leans_px
            By how much places move with a relative change of the radius, shape (N, 2): by nothing
            where the whole rim is seen, by the radius where one side is.
        """
        share = min(1.0, float(np.median(np.hypot(*leans_px.T))) / self.radius_px)
        sigma = ONE_SIDED_SIGMA * share**2 * self.radius_px
        return replace(self, radius_sigma_px=math.hypot(self.radius_sigma_px, sigma))


def find_discs_that_move(
    samples: dict[int, Picture],
    ground: Picture,
    changed: dict[int, NDArray[np.bool_]],
    radii_px: tuple[float, float],
) -> list[tuple[int, Disc]]:
    """Return discs of what differs from what stands still, with their frames.

    Parameters
    ----------
    changed
        Which pixels of each frame do, shape (rows, columns).
    """
    low, high = radii_px
    every = -(-len(samples) // MOST_SEARCHED)
    sought = []
    for number, picture in list(samples.items())[::every]:
        windows = _windows(changed[number], low)
        if windows:
            sought.append((sum(map(_area, windows)), number, picture, windows))
    sought.sort(key=lambda each: each[:2])
    spent = np.cumsum([area for area, *_ in sought])
    enough = max(LEAST_SEARCHED, int((spent < MOST_SOUGHT_PX).sum()))

    def discs_in(place: tuple[int, Picture, tuple[slice, slice]]) -> list[tuple[int, Disc]]:
        number, picture, window = place
        own = picture[window].astype(np.float32) - ground[window].astype(np.float32)
        largest = min(high, 0.6 * max(own.shape[:2]))
        if largest <= low:
            return []
        top, left = window[0].start, window[1].start
        discs = find_balls(own, (low, largest), LEAST_ALARMS, blotched=False)
        return [(number, replace(d, row=d.row + top, column=d.column + left)) for d in discs]

    places = [(n, picture, w) for _, n, picture, windows in sought[:enough] for w in windows]
    return list(chain.from_iterable(threads.each(discs_in, places)))


def _area(window: tuple[slice, slice]) -> int:
    rows, columns = window
    return int((rows.stop - rows.start) * (columns.stop - columns.start))


def _windows(changed: NDArray[np.bool_], low: float) -> list[tuple[slice, slice]]:
    """Return windows about what has changed, parts that lie near one another together."""
    factor = max(1, int(low))
    rows, columns = changed.shape
    size = (max(1, columns // factor), max(1, rows // factor))
    small = cv2.resize(changed.astype(np.uint8) * 255, size, interpolation=cv2.INTER_AREA)
    near = cv2.dilate((np.asarray(small) > 0).astype(np.uint8), np.ones((5, 5), np.uint8))
    _, _, stats, _ = cv2.connectedComponentsWithStats(near)
    found = []
    for left, top, width, height, _ in np.asarray(stats)[1:].tolist():
        box = (
            slice(top * factor, (top + height) * factor),
            slice(left * factor, (left + width) * factor),
        )
        if changed[box].sum() < LEAST_CHANGED:
            continue
        margin = factor + 4
        found.append(
            (
                slice(max(0, box[0].start - margin), min(rows, box[0].stop + margin)),
                slice(max(0, box[1].start - margin), min(columns, box[1].stop + margin)),
            )
        )
    return found


def families(found: Sequence[tuple[int, Disc]]) -> list[list[tuple[int, Disc]]]:
    """Return discs in groups of like radius, the surest group first."""
    rest = sorted(found, key=lambda each: each[1].log_alarms)
    groups: list[list[tuple[int, Disc]]] = []
    while rest:
        best: list[tuple[int, Disc]] = []
        most = 0.0
        for _, centre in rest[:40]:
            alike = [each for each in rest if abs(np.log(each[1].radius / centre.radius)) < ALIKE]
            if weight(alike) > most:
                best, most = alike, weight(alike)
        groups.append(best)
        rest = [each for each in rest if all(each is not other for other in best)]
    return groups


def weight(family: Sequence[tuple[int, Disc]]) -> float:
    """Return how sure a family is: of each frame its surest disc counts, which comes first."""
    by_frame = dict(reversed(family))
    return -sum(disc.log_alarms for disc in by_frame.values())


def looks_of(
    family: Sequence[tuple[int, Disc]], samples: dict[int, Picture], ground: Picture, head: FilmHead
) -> Looks:
    """Return what a ball looks like from discs of one radius.

    The radius is the rim's of the sharpest half, each counted by how sure it is. The channel of the
    rim is Fisher's, the ground's colour counted as noise: shadows drop out where there is colour
    (Fisher, 1936).
    """
    radii = np.array([disc.radius for _, disc in family])
    rims = np.array([disc.rim for _, disc in family])
    sharp = rims >= np.median(rims)
    radius = weighted_median(
        radii[sharp], 1.0 / np.array([disc.radius_sigma for _, disc in family])[sharp]
    )
    spread = 1.4826 * float(np.median(np.abs(radii[sharp] - radius))) / np.sqrt(sharp.sum())
    pixels = [_pixels(samples[number], ground, disc) for number, disc in family]
    ball, still = (np.concatenate([each[k] for each in pixels]) for k in (0, 1))
    terms = np.concatenate([shaded for _, _, shaded in pixels])
    shading, left = _smooth(terms, ball)
    least = CODEC_LEVELS if head.compressed else 1.0
    lit, behind = light(ball, head), light(still, head)
    patches = _patches(terms, lit, behind)
    patched = patches > LEAST_PATCHES
    return Looks(
        radius_px=radius,
        radius_sigma_px=math.hypot(spread, RIM_SIGMA * radius, CODEC_PX * head.compressed),
        shading=shading,
        spread=left + least**2 * np.eye(head.channels),
        light_weights=patched_weights(lit, behind)
        if patched
        else rim_weights(lit, behind, head, radius),
        seen=tuple(family),
        patches=patches,
    )


def weighted_median(values: Floats, weights: Floats) -> float:
    """Return the median of values that count differently."""
    order = np.argsort(values)
    passed = np.cumsum(weights[order]) - 0.5 * weights[order]
    return float(np.interp(0.5 * weights.sum(), passed, values[order]))


def _pixels(picture: Picture, ground: Picture, disc: Disc) -> tuple[Picture, Picture, Floats]:
    """Return a disc's pixels, those behind them, and the terms of its shading at each."""
    rows, columns, _ = picture.shape
    reach = int(np.ceil(disc.radius))
    row, column = (
        np.arange(max(0, int(middle) - reach), min(most, int(middle) + reach + 1))
        for middle, most in ((disc.row, rows), (disc.column, columns))
    )
    down, right = np.meshgrid(row, column, indexing="ij")
    u, v = (down - disc.row) / disc.radius, (right - disc.column) / disc.radius
    within = np.hypot(u, v) < INSIDE_RADII
    own = down[within], right[within]
    return picture[own], ground[own], shaded(u[within], v[within])


def shaded(u: Floats, v: Floats) -> Floats:
    """Return the terms of a smooth shading at places in radii from the centre, shape (..., TERMS).

    As `photometry` has them.
    """
    return np.stack([np.ones_like(u), u, v, u * v, u * u - v * v, u * u + v * v], axis=-1)


def _smooth(terms: Floats, values: Picture) -> tuple[Floats, Floats]:
    """Return the shading that explains a ball's values, and the covariance of what it leaves."""
    shading = np.linalg.lstsq(terms, values.astype(np.float64), rcond=None)[0]
    left = values - terms @ shading
    return np.asarray(shading, np.float64), np.asarray(left.T @ left / max(1, len(left)))


def _patches(terms: Floats, ball: Singles, still: Singles) -> float:
    """Return what a smooth shading leaves of a ball's light over that of ball less ground."""
    left = ball - terms @ np.linalg.lstsq(terms, ball.astype(np.float64), rcond=None)[0]
    whole = float(((ball - still).astype(np.float64) ** 2).sum())
    return math.sqrt(float((left**2).sum()) / max(whole, 1e-12))


def patched_weights(ball: Singles, still: Singles) -> Floats:
    """Return weights for light at the rim of a ball with patches: brightness.

    Patches differ in brightness, most of all; a difference of colours that tells all of them from
    the ground is faint. Brightness is measured by squares: white and black may be as bright as the
    ground in the mean.
    """
    channels = ball.shape[1]
    weights = BRIGHTNESS if channels == len(BRIGHTNESS) else np.full(channels, 1.0 / channels)
    apart = (ball - still).astype(np.float64) @ weights
    return np.asarray(weights / max(math.sqrt(float((apart**2).mean())), 1e-9))


def rim_weights(ball: Singles, still: Singles, head: FilmHead, radius_px: float) -> Floats:
    """Return weights for light at the rim: brightness where a codec has halved the colours.

    Of a large ball half of the colours is enough, and a shadow on the wall behind it, which goes
    with it, drops out.
    """
    colours = _fisher(ball, still)
    if head.channels != 3 or not head.compressed:
        return colours
    faint = float(np.hypot.reduce(colours)) * CODEC_LEVELS > MOST_CODEC_NOISE
    difference = (ball.mean(axis=0) - still.mean(axis=0)).astype(np.float64)
    brightness = float(BRIGHTNESS @ difference)
    dark = abs(brightness) <= LEAST_BRIGHTNESS * float(np.abs(difference).max())
    if dark or (radius_px >= 2 * CODED_RADIUS_PX and not faint):
        return colours
    return BRIGHTNESS / brightness


def _fisher(ball: NDArray[np.generic], still: NDArray[np.generic]) -> Floats:
    inside, behind = np.asarray(ball, np.float64), np.asarray(still, np.float64)
    difference = inside.mean(axis=0) - behind.mean(axis=0)
    if len(difference) == 1:
        return np.asarray(1.0 / np.where(difference == 0, 1.0, difference))
    base = behind.mean(axis=0)
    within = [np.asarray(np.cov(each.T), dtype=np.float64) for each in (inside, behind)]
    spread = within[0] + within[1] + np.eye(len(difference))
    scale = float(np.trace(spread)) / len(difference)
    colour = np.outer(base, base) / float(base @ base)
    weights = np.linalg.solve(spread + SHADOW_WEIGHT * scale * colour, difference)
    return np.asarray(weights / float(weights @ difference))
