"""Where discs of a known pair are: what part of the pictures moves, votes, flights through them.

Background, noise, votes and masks cost a pixel each, wherever it lies; most of a picture of a
million pixels never shows a sphere. In what is left every strong gradient votes for the centre that
it points to, and free flights that one contact joins go through the places of many votes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Grey
from analysis.compiled import compiled
from analysis.imaging.flight_hypotheses import Falling, guide, meeting, mirrored, within
from analysis.photometric.learn.appearance import Appearance
from analysis.photometric.render.camera import Camera

BLOCK_PX, EVERY = 8, 4
"""Of its rows these are looked at."""
CHANGES, LEAST_CHANGE = 2.0, 1.0
"""Mean range of a block that something passes: in that of the median block, and grey levels more.
Noise alone gives each block the same range within a tenth."""
MOST_OF_PICTURE = 0.5
"""A larger part saves less than its cutting costs."""


@dataclass(frozen=True, slots=True)
class Part:
    """A rectangle of a picture: half-open ranges of rows and columns."""

    rows: tuple[int, int]
    columns: tuple[int, int]

    def of(self, frames: Grey) -> Grey:
        """Return this part of frames, shape (frames, rows, columns)."""
        return frames[:, slice(*self.rows), slice(*self.columns)]

    def shown(self, known: Appearance) -> Appearance:
        """Return a pair as its camera shows it in pixels of this part."""
        optics = known.camera.optics
        top, left = self.rows[0], self.columns[0]
        optics = optics._replace(
            origins=optics.origins - np.array([top, left]),
            rows=np.clip(optics.rows - top, 0, self.rows[1] - top),
            middle=(optics.middle[0] - top, optics.middle[1] - left),
        )
        return replace(known, camera=replace(known.camera, optics=optics))

    def whole(self, shown: Appearance, known: Appearance) -> Appearance:
        """Return a pair that was learned in this part in pixels of the picture `known` is of."""
        optics = shown.camera.optics
        optics = optics._replace(
            origins=optics.origins + np.array([self.rows[0], self.columns[0]]),
            rows=known.camera.optics.rows,
            middle=known.camera.optics.middle,
        )
        return replace(shown, camera=replace(shown.camera, optics=optics))


def moving_part(frames: Grey, known: Appearance) -> Part | None:
    """Find the part of the pictures that a pair's spheres pass.

    None where nothing moves, or where most of the picture does. The part reaches a diameter
    beyond what changes: a sphere may be as bright as what is behind it on one side.

    Parameters
    ----------
    frames
        Grey levels, shape (frames, rows, columns).
    """
    changing = _changing(frames)
    if not changing.any():
        return None
    radius = max(sphere.radius_m for sphere in known.spheres) * known.camera.optics.scales.max()
    around = int(np.ceil(2.0 * radius))
    ranges = []
    for axis, most in ((1, frames.shape[1]), (0, frames.shape[2])):
        blocks = np.flatnonzero(changing.any(axis=axis))
        low = max(0, int(blocks[0]) * BLOCK_PX - around)
        ranges.append((low, min(most, (int(blocks[-1]) + 1) * BLOCK_PX + around)))
    (top, bottom), (left, right) = ranges
    if (bottom - top) * (right - left) > MOST_OF_PICTURE * frames[0].size:
        return None
    return Part((top, bottom), (left, right))


def _changing(frames: Grey) -> NDArray[np.bool_]:
    """Return in which blocks of the picture something passes; the last rows may make none."""
    seen = frames[:, ::EVERY]
    change = seen.max(axis=0) - seen.min(axis=0)
    high = BLOCK_PX // EVERY
    down, across = change.shape[0] // high, change.shape[1] // BLOCK_PX
    blocks = change[: down * high, : across * BLOCK_PX]
    if blocks.size == 0:
        return np.zeros((down, across), dtype=np.bool_)
    means = cv2.resize(blocks.astype(np.float32), (across, down), interpolation=cv2.INTER_AREA)
    return np.asarray(means > CHANGES * np.median(means) + LEAST_CHANGE)


Single = NDArray[np.float32]

SMOOTH_PX = 1.2
GATHER_PX = 1.3
BEYOND_NOISE = 6.0
SPREAD_PX = 0.7
LEAST_SHARE = 0.25
"""Of the votes that a whole, evenly lit outline would give."""


@compiled
def cast(rows: Single, columns: Single, least: float, radius: float, votes: Single) -> None:
    """Add the votes of every pixel whose gradient exceeds `least`.

    Parameters
    ----------
    rows, columns
        Gradient of the frame less background, grey levels a pixel, shape (rows, columns).
    votes
        Added to, same shape.
    """
    for i in range(rows.shape[0]):
        for j in range(rows.shape[1]):
            d_r, d_c = rows[i, j], columns[i, j]
            square = d_r * d_r + d_c * d_c
            if square < least * least:
                continue
            size = math.sqrt(square)
            for k in range(-1, 2):
                reach = (radius + SPREAD_PX * k) / size
                y, x = int(np.rint(i + reach * d_r)), int(np.rint(j + reach * d_c))
                if 0 <= y < votes.shape[0] and 0 <= x < votes.shape[1]:
                    votes[y, x] += 1.0


def vote_map(frame: Grey, background: Floats, noise: float, radius: float) -> Single:
    """Return the votes for a disc's centre at each pixel as a share of a whole outline's."""
    off = np.abs(frame.astype(np.float32) - background.astype(np.float32))
    smooth = cv2.GaussianBlur(off, (0, 0), SMOOTH_PX)
    # Sobel's weights sum to 8 grey levels for a slope of one a pixel.
    rows, columns = (
        np.asarray(cv2.Sobel(smooth, cv2.CV_32F, *along, scale=1 / 8), dtype=np.float32)
        for along in ((0, 1), (1, 0))
    )
    noise_slope = noise / (math.sqrt(8 * math.pi) * SMOOTH_PX**2)
    votes = np.zeros(off.shape, dtype=np.float32)
    cast(rows, columns, BEYOND_NOISE * noise_slope, radius, votes)
    gathered = cv2.GaussianBlur(votes, (0, 0), GATHER_PX)
    whole = 3 * 2 * math.pi * radius * 3 * SMOOTH_PX / (2 * math.pi * GATHER_PX**2 * 3)
    return np.asarray(gathered / whole, dtype=np.float32)


def peak_near(votes: Single, place: tuple[float, float], reach: float) -> tuple[float, float]:
    """Return the best supported place within `reach` pixels, to a fraction of a pixel.

    The place itself comes back where nothing near it has votes.
    """
    rows, columns = votes.shape
    top, left = max(int(place[0] - reach), 0), max(int(place[1] - reach), 0)
    part = votes[top : int(place[0] + reach) + 2, left : int(place[1] + reach) + 2]
    if part.size == 0 or part.max() < LEAST_SHARE:
        return place
    i, j = np.unravel_index(int(part.argmax()), part.shape)
    return _vertex(
        votes, min(max(int(i) + top, 1), rows - 2), min(max(int(j) + left, 1), columns - 2)
    )


def _vertex(votes: Single, i: int, j: int) -> tuple[float, float]:
    """Return the vertex of parabolas through a maximum and its neighbours."""
    along = votes[i - 1 : i + 2, j].astype(np.float64)
    across = votes[i, j - 1 : j + 2].astype(np.float64)
    off = []
    for low, middle, high in (along, across):
        bend = low - 2 * middle + high
        off.append(float(np.clip(0.5 * (low - high) / bend, -1, 1)) if bend < 0 else 0.0)
    return i + off[0], j + off[1]


def peaks(votes: Single, count: int, apart: float) -> list[tuple[float, float, float]]:
    """Return the `count` best supported places at least `apart` pixels from each other.

    Each with row, column and share; fewer where fewer have votes.
    """
    left, around = votes.copy(), math.ceil(apart)
    found: list[tuple[float, float, float]] = []
    for _ in range(count):
        i, j = map(int, np.unravel_index(int(left.argmax()), left.shape))
        share = float(left[i, j])
        if share < LEAST_SHARE:
            break
        inner = 0 < i < votes.shape[0] - 1 and 0 < j < votes.shape[1] - 1
        row, column = _vertex(votes, i, j) if inner else (float(i), float(j))
        found.append((row, column, share))
        top, first, reach = max(i - around, 0), max(j - around, 0), around + 1
        near = left[top : i + reach, first : j + reach]
        y, x = np.ogrid[top : top + near.shape[0], first : first + near.shape[1]]
        near[(y - i) ** 2 + (x - j) ** 2 < apart**2] = 0.0
    return found


MOST_DISCS = 8
"""Of a size, that a frame is searched for."""

Votes = Sequence[NDArray[np.float32]]
"""For the centres of discs of one size, of each frame."""


def whereabouts_by_flights(
    votes: tuple[Votes, Votes], radii: tuple[float, float], camera: Camera, falling: Falling
) -> Floats | None:
    """Return the centres of a and b, m, shape (2, frames, 3); not a number where they are not seen.

    None where no flights meet.

    Parameters
    ----------
    votes
        For discs of the size of a and of b; the same for spheres alike.
    radii
        Of a and b, pixels.
    """
    split = int(camera.optics.rows[1, 1]) if len(camera.views) > 1 else 0
    a = _discs(votes[0], radii[0])
    seen = a, a if radii[0] == radii[1] else _discs(votes[1], radii[1])
    four = meeting(seen, (split, math.inf), radii, falling)
    if four is None:
        return None
    centres = np.full((2, len(falling.times_s), 3), np.nan)
    for i, places in enumerate(guide(four, falling)):
        for k in np.flatnonzero(np.isfinite(places[:, 0])):
            centres[i, k, :2] = camera.at_pixels(0, (places[k, 0], places[k, 1]), 0.0)
    if len(camera.views) > 1:
        shift = float(camera.optics.origins[1, 1] - camera.optics.origins[0, 1])
        shown = [[within(own, (0, split)) for own in every] for every in seen]
        for i, flown in enumerate(mirrored(four, shown, radii, shift, falling)):
            for own in flown:
                for k, place in zip(own.frames, own.places.tolist(), strict=True):
                    centres[i, k, 2] = -camera.at_pixels(1, tuple(place), 0.0)[0]
    return centres


def _discs(votes: Votes, radius: float) -> list[Floats]:
    """Return rows and columns of the discs of each frame, shape (discs, 2)."""
    return [
        np.array([place[:2] for place in peaks(each, MOST_DISCS, radius)]).reshape(-1, 2)
        for each in votes
    ]
