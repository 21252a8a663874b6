"""Where a known pair is in all frames of a film at once: by free flights that one contact joins."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.imaging.flight_hypotheses import (
    Falling,
    Flight,
    above,
    free_flights,
    guide,
    meeting,
)
from analysis.photometric.follow.votes import peaks
from analysis.photometric.render.camera import Camera

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
    seen = [_discs(own, radius) for own, radius in zip(votes, radii, strict=True)]
    flights = [
        free_flights([own[own[:, 0] >= split] for own in every], radius, falling)
        for every, radius in zip(seen, radii, strict=True)
    ]
    if radii[0] == radii[1]:
        flights[1] = flights[0]
    four = meeting((flights[0], flights[1]), radii, falling)
    if four is None:
        return None
    centres = np.full((2, len(falling.times_s), 3), np.nan)
    for i, places in enumerate(guide(four, falling)):
        for k in np.flatnonzero(np.isfinite(places[:, 0])):
            centres[i, k, :2] = camera.at_pixels(0, (places[k, 0], places[k, 1]), 0.0)
    if len(camera.views) > 1:
        shift = float(camera.optics.origins[1, 1] - camera.optics.origins[0, 1])
        for i, flight in _each(four):
            shown = [own[own[:, 0] < split] for own in seen[i]]
            own = above(flight, shown, radii[i], shift, falling)
            if own is not None:
                for k, place in zip(own.frames, own.places.tolist(), strict=True):
                    centres[i, k, 2] = -camera.at_pixels(1, tuple(place), 0.0)[0]
    return centres


def _discs(votes: Votes, radius: float) -> list[Floats]:
    """Return rows and columns of the discs of each frame, shape (discs, 2)."""
    return [
        np.array([place[:2] for place in peaks(each, MOST_DISCS, radius)]).reshape(-1, 2)
        for each in votes
    ]


def _each(four: tuple[tuple[Flight, Flight], tuple[Flight, Flight]]) -> list[tuple[int, Flight]]:
    return [(i, four[i][n]) for i, n in product((0, 1), (0, 1))]
