"""Pieces of free flight in what looks like a ball, and the chain of them that bounces make.

A ball may move by many radii from frame to frame: sightings belong together where one free fall
goes through them, not where they are near.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.seen.growing import MEMORY, MOST_MISSES, course, grow

Ints = NDArray[np.intp]

FALL_SIGMA = 0.15
"""Relative, of the fall in pixels that follows from the ball's size in the picture."""
LEAST_FRAMES = 4
TOLERANCE_RADII, TOLERANCE_PX = 0.35, 1.0
MOST_SEED_RADII = 14.0
"""A ball moves by no more of its radii from one frame to the next."""


@dataclass(frozen=True, slots=True, eq=False)
class Arc:
    """A ball in free flight: frames, their times in s and its places (row, column) in pixels.

    Attributes
    ----------
    frames, times_s, places
        Shapes (N,), (N,), (N, 2).
    strength
        Sum of the responses.
    """

    frames: Ints
    times_s: Floats
    places: Floats
    strength: float

    def course(self, fall: Floats, *, end: bool) -> tuple[float, Floats, Floats]:
        """Return a time in the arc, and place and velocity then, near its end or its start."""
        return self.course_of(slice(-MEMORY, None) if end else slice(0, MEMORY), fall)

    def part(self, first: int, last: int) -> Arc:
        """Return the sightings from one up to another."""
        share = (last - first) / len(self.frames)
        own = slice(first, last)
        return Arc(self.frames[own], self.times_s[own], self.places[own], share * self.strength)

    def course_of(self, part: slice, fall: Floats) -> tuple[float, Floats, Floats]:
        """Return the same of some of its sightings."""
        places = np.ascontiguousarray(self.places[part])
        return course(np.ascontiguousarray(self.times_s[part]), places, fall)


@dataclass(frozen=True, slots=True, eq=False)
class Sightings:
    """Everything that looks like the ball.

    Attributes
    ----------
    times_s
        Of the frames, shape (frames,).
    places
        Of each frame row, column, response; arrays of shape (N, 3).
    shape
        Rows and columns of the picture.
    """

    times_s: Floats
    places: Sequence[Floats]
    shape: tuple[int, int]


def find_arcs(seen: Sightings, radius_px: float, fall: Floats) -> list[Arc]:
    """Return pieces of free flight, in order of time; no sighting belongs to two.

    Parameters
    ----------
    fall
        Acceleration of free fall in the picture, (row, column) in px/s^2.
    """
    free = [np.ones(len(each), dtype=bool) for each in seen.places]
    search = _Search(seen, radius_px, fall, free)
    arcs = []
    while (arc := search.best()) is not None:
        arcs.append(arc)
    return sorted(arcs, key=lambda arc: float(arc.times_s[0]))


class _Search:
    def __init__(
        self, seen: Sightings, radius_px: float, fall: Floats, free: list[NDArray[np.bool_]]
    ) -> None:
        frames, most = len(seen.places), max((len(each) for each in seen.places), default=0)
        self._seen = seen
        self._places = np.full((frames, most, 2), np.inf)
        self._free = np.zeros((frames, most), dtype=bool)
        for frame, places in enumerate(seen.places):
            self._places[frame, : len(places)] = places[:, :2]
            self._free[frame, : len(places)] = free[frame]
        self._rules = np.array(
            [
                TOLERANCE_RADII * radius_px + TOLERANCE_PX,
                MOST_SEED_RADII * radius_px,
                *map(float, seen.shape),
                *fall.tolist(),
            ]
        )
        self._taken = np.zeros((frames, 2), dtype=np.intp)
        self._tried: set[tuple[int, int, int]] = set()

    def best(self) -> Arc | None:
        """Return the next arc from the strongest seed that is left, and take its sightings."""
        for first in range(len(self._free) - 1):
            for a in np.flatnonzero(self._free[first]).tolist():
                for b in np.flatnonzero(self._free[first + 1]).tolist():
                    if (first, a, b) in self._tried:
                        continue
                    self._tried.add((first, a, b))
                    self._taken[0], self._taken[1] = (first, a), (first + 1, b)
                    known = self._seen.times_s, self._places, self._free
                    count = grow(*known, self._rules, self._taken)
                    if count >= LEAST_FRAMES:
                        return self._take([(int(k), int(i)) for k, i in self._taken[:count]])
        return None

    def _take(self, taken: list[tuple[int, int]]) -> Arc:
        for frame, index in taken:
            self._free[frame, index] = False
        frames = np.array([frame for frame, _ in taken])
        rows = np.array([self._seen.places[k][i] for k, i in taken])
        return Arc(frames, self._seen.times_s[frames], rows[:, :2], float(rows[:, 2].sum()))


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """Arcs one after another, and between them where and when their courses meet.

    Attributes
    ----------
    arcs
        In order of time.
    times_s, places
        Of the bounces between, shapes (B,) and (B, 2).
    """

    arcs: tuple[Arc, ...]
    times_s: Floats
    places: Floats

    @property
    def strength(self) -> float:
        """Return the sum of all responses."""
        return sum(arc.strength for arc in self.arcs)


def chains(arcs: Sequence[Arc], radius_px: float, fall: Floats) -> list[Chain]:
    """Return chains of arcs that meet in bounces, the strongest first; each arc is in one."""
    rest, found = list(arcs), []
    while rest:
        best = _strongest(rest, radius_px, fall)
        found.append(best)
        rest = [arc for arc in rest if all(arc is not other for other in best.arcs)]
    return sorted(found, key=lambda chain: -chain.strength)


def _strongest(arcs: list[Arc], radius_px: float, fall: Floats) -> Chain:
    ends: list[tuple[float, int | None, tuple[float, Floats] | None]] = []
    for k, arc in enumerate(arcs):
        best: tuple[float, int | None, tuple[float, Floats] | None] = (arc.strength, None, None)
        for j in range(k):
            meeting = _meeting(arcs[j], arc, radius_px, fall)
            if meeting is not None and ends[j][0] + arc.strength > best[0]:
                best = (ends[j][0] + arc.strength, j, meeting)
        ends.append(best)
    last: int | None = int(np.argmax([end[0] for end in ends]))
    chosen, meetings = [], []
    while last is not None:
        chosen.append(arcs[last])
        _, last_before, meeting = ends[last]
        if meeting is not None:
            meetings.append(meeting)
        last = last_before
    meetings.reverse()
    return Chain(
        tuple(reversed(chosen)),
        np.array([time for time, _ in meetings]),
        np.array([place for _, place in meetings]).reshape(-1, 2),
    )


def _meeting(a: Arc, b: Arc, radius_px: float, fall: Floats) -> tuple[float, Floats] | None:
    """Return when and where two courses meet in a bounce; None where they do not."""
    step = float(np.median(np.diff(a.times_s)))
    if b.frames[0] <= a.frames[-1] - LEAST_FRAMES:
        return None
    at, place_a, velocity_a = a.course(fall, end=True)
    bt, place_b, velocity_b = b.course(fall, end=False)
    # Both at the time zero of the first: with the same fall their distance is linear in time.
    gone = at - bt
    place_b = place_b + velocity_b * gone + 0.5 * fall * gone**2
    velocity_b = velocity_b + fall * gone
    jump = velocity_b - velocity_a
    size = float(jump @ jump)
    if size <= 0 or np.sqrt(size) * step < 0.05:
        return None
    shift = -float((place_b - place_a) @ jump) / size
    apart = place_b - place_a + jump * shift
    time = at + shift
    margin = (MOST_MISSES + 1.5) * step
    if not a.times_s[-1] - margin <= time <= b.times_s[0] + margin:
        return None
    if b.times_s[0] - a.times_s[-1] > 4 * margin:
        return None
    if float(np.hypot(*apart)) > 1.5 * radius_px:
        return None
    return time, place_a + velocity_a * shift + 0.5 * fall * shift**2
