"""What the errors of different shots have in common where their spheres are near each other.

The mean product of two errors of different shots, by the distance of the two places: what is the
same all over the field is in all distances, what changes with the place in the near ones alone.
What a shot has for itself is in none.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from benchmarks.tracks.flights import Flight

Floats = NDArray[np.float64]

EDGES_M = np.array([0.0, 2.0, 5.0, 10.0, 20.0, 40.0]) * 1e-3
MOST = {"place": 5e-5, "turn": 5e-3}
"""m and rad: what is further off is a torn track."""


def shared_sizes(every: Sequence[Flight], what: str, sphere: int, axis: int) -> Floats:
    """Return signed roots of the mean products by distance, m or rad, shape (distances,)."""
    places, errors, shots = map(np.concatenate, zip(*_of(every, what, sphere, axis), strict=True))
    apart = np.linalg.norm(places[:, None] - places, axis=2)
    product, other = np.outer(errors, errors), shots[:, None] != shots
    means = [
        product[other & (apart >= near) & (apart < far)].mean() for near, far in pairwise(EDGES_M)
    ]
    return np.sign(means) * np.sqrt(np.abs(means))


def _of(
    every: Sequence[Flight], what: str, sphere: int, axis: int
) -> Iterator[tuple[Floats, Floats, NDArray[np.intp]]]:
    for flight in every:
        if flight.sphere != sphere:
            continue
        rows, errors = np.arange(len(flight.frames)), flight.place_errors[:, axis]
        if what == "turn":
            known = np.isin(flight.turned, flight.frames)
            rows = np.searchsorted(flight.frames, flight.turned[known])
            errors = flight.turns[known, axis]
        good = np.isfinite(errors) & (np.abs(errors) < MOST[what])
        count = int(good.sum())
        yield flight.places[rows][good], errors[good], np.full(count, flight.shot)


def show_shared(every: Sequence[Flight]) -> None:
    """Print the sizes of a campaign, um and mrad, by distance."""
    ends = "".join(f"{1e3 * far:>8.0f}" for far in EDGES_M[1:])
    print(f"  shared by shots at places as near as, mm {ends}")
    for what, unit in (("place", 1e6), ("turn", 1e3)):
        for sphere in (0, 1):
            for axis, name in enumerate("XYZ"):
                sizes = unit * shared_sizes(every, what, sphere, axis)
                row = "".join(f"{one:+8.2f}" for one in sizes)
                print(f"  {what:6s}{'ab'[sphere]}, {name:31s}{row}")
