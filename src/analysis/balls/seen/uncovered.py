"""What stands still behind a ball that rests: frames of its flights show it, and most do not.

The middle of all frames is the ball itself where it lies for half of a film. What differs from that
is a crescent, by some pixels beside the ball, wherever it flies near the place where it rests.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.films.film import Picture
from analysis.balls.seen.arcs import Chain
from analysis.balls.seen.background import background_without, changed

LEAST_UNFLOWN = 0.1
"""Of the frames that are looked at: where the ball does not fly in so many, it may hide a place in
most of them."""
LEAST_SHOWN = 3
"""Frames of flights in which a pixel is seen, that tell it."""
HIDES_RADII, HIDES_PX = 1.5, 2.0
"""From the ball's centre: what it hides, with its smear."""
AROUND_RADII = 3.0
"""About the places where a ball may rest: what is learned again."""
LEAST_OF_DISC = 0.25
"""Of the ball's area: a ground that differs over less is the same."""


def uncovered(
    samples: Mapping[int, Picture],
    ground: Picture,
    noise: float,
    ball: tuple[float, Chain, Floats],
) -> Picture | None:
    """Return what stands still as frames of the flights show it; None where that is the same.

    Parameters
    ----------
    samples
        Frames, all as bright as one another, of shape (rows, columns, channels).
    ground, noise
        The middle of all of them, and the noise of a pixel.
    ball
        Its radius, px, its flights, and frame, row and column outside them, shape (N, 3).
    """
    radius_px, chain, beside = ball
    flown = {
        int(frame): place
        for arc in chain.arcs
        for frame, place in zip(arc.frames, arc.places, strict=True)
    }
    own = [(picture, flown[k]) for k, picture in samples.items() if k in flown]
    if len(own) < LEAST_SHOWN or len(samples) - len(own) < LEAST_UNFLOWN * len(samples):
        return None
    near = _near(radius_px, chain, beside, ground.shape)
    box = _box(near)
    hidden = [_hides(box, place, radius_px) for _, place in own]
    told = near[box] & (len(own) - np.sum(hidden, axis=0) >= LEAST_SHOWN)
    channels = [
        background_without([picture[(*box, k)].astype(np.float32) for picture, _ in own], hidden)
        for k in range(ground.shape[2])
    ]
    bare = ground.copy()
    bare[box] = np.where(told[..., None], np.rint(np.stack(channels, axis=2)), ground[box])
    apart = changed(bare[box], ground[box], noise)
    if np.count_nonzero(apart) < LEAST_OF_DISC * np.pi * radius_px**2:
        return None
    return bare


def _near(
    radius_px: float, chain: Chain, beside: Floats, shape: tuple[int, ...]
) -> NDArray[np.bool_]:
    """Return where a ball may rest: at bounces, at both ends of its flights, and outside them."""
    ends = np.array([chain.arcs[0].places[0], chain.arcs[-1].places[-1]])
    places = np.concatenate([ends, chain.places, beside[:, 1:]])
    near = np.zeros(shape[:2], np.uint8)
    for row, column in np.rint(places).astype(int).tolist():
        cv2.circle(near, (column, row), math.ceil(AROUND_RADII * radius_px), 1, cv2.FILLED)
    return near > 0


def _box(near: NDArray[np.bool_]) -> tuple[slice, slice]:
    """Return the rows and columns that hold all of some pixels."""
    rows, columns = (np.flatnonzero(near.any(axis=axis)).tolist() or [0] for axis in (1, 0))
    return slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)


def _hides(box: tuple[slice, slice], place: Floats, radius_px: float) -> NDArray[np.bool_]:
    rows, columns = np.ogrid[box]
    reach = HIDES_RADII * radius_px + HIDES_PX
    return np.asarray(np.hypot(rows - place[0], columns - place[1]) < reach)
