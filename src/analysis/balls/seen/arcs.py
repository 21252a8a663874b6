"""Pieces of free flight in what looks like a ball, and the chain of them that bounces make.

A ball may move by many radii from frame to frame: sightings belong together where one free fall
goes through them, not where they are near. A flight that goes on above or beside the picture is one
arc.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.seen.growing import LEAST_FRAMES, MEMORY, MOST_MISSES, course, next_arc

Ints = NDArray[np.intp]
Real = TypeVar("Real", float, Floats)
Meeting = tuple[float, Floats]
"""When and where the courses of two arcs meet in a bounce, s and px."""

FALL_SIGMA = 0.15
"""Relative, of the fall in pixels that follows from the ball's size in the picture."""
TOLERANCE_RADII, TOLERANCE_PX = 0.35, 1.0
MOST_MOVED = 0.5
"""Scatter about one place over that about a fall, of places that rest."""
STILL_RADII, STILL_PX, MOST_STILL, MOST_COMPARED = 0.1, 1.0, 0.5, 24
"""What stands still is seen within so much of one place; the share of an arc's sightings that are
of such things, where it is no flight; and how many of them are looked at."""
SHOWN_AT_REST, MOST_REMEMBERED = 12.0, 500
"""An arc is continued from the time T in which a ball at rest leaves one that falls: g T^2 / 12
at its ends is the tolerance then; and from so many sightings at most."""
OVER_BOUNCE = 6
"""One of so many of these sightings may lie on the other side of a bounce."""
MOST_E = 2.0
"""Speed after a bounce over that before it, as few sightings tell them: a plate at rest gives none,
and what leaves faster was in pieces of its flights."""
MOST_APART_RADII = 1.5
"""Between two courses where they meet; and by how much sightings of one lie off the other one on
the wrong side of the bounce."""
MOST_DOWN = 0.5
"""Of the change of speed in a bounce, along the fall: floors push against it, and walls across."""
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
        return self.of(np.arange(len(self.frames))[first:last])

    def of(self, chosen: Ints) -> Arc:
        """Return some sightings, in the order of their numbers."""
        share = len(chosen) / len(self.frames)
        own = self.frames[chosen], self.times_s[chosen], self.places[chosen]
        return Arc(*own, share * self.strength)

    def course_of(self, part: slice, fall: Floats) -> tuple[float, Floats, Floats]:
        """Return the same of some of its sightings."""
        places = np.ascontiguousarray(self.places[part])
        return course(np.ascontiguousarray(self.times_s[part]), places, fall)

    def rests(self, fall: Floats) -> bool:
        """Return whether its places stay where they are far more closely than they fall.

        A search with a wide tolerance takes a ball that is held for some frames of a fall.
        """
        middle, place, speed = self.course_of(slice(None), fall)
        gone = (self.times_s - middle)[:, None]
        falling = self.places - (place + speed * gone + 0.5 * fall * gone**2)
        staying = self.places - self.places.mean(axis=0)
        return bool((staying**2).sum() < MOST_MOVED**2 * (falling**2).sum())


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

    What rests is no flight, nor is a way from one thing that stands still to another.

    Parameters
    ----------
    fall
        Acceleration of free fall in the picture, (row, column) in px/s^2.
    """
    free = [np.ones(len(each), dtype=bool) for each in seen.places]
    search = _Search(seen, radius_px, fall, free)
    arcs = []
    while (arc := search.best()) is not None:
        if not arc.rests(fall) and not search.goes_between(arc):
            arcs.append(arc)
    return sorted(arcs, key=lambda arc: float(arc.times_s[0]))


def tolerance(radius_px: float) -> float:
    """Return how far from its course a sighting of an arc may lie, px."""
    return TOLERANCE_RADII * radius_px + TOLERANCE_PX


def _remembered(times_s: Floats, radius_px: float, fall: Floats) -> int:
    """Return from how many sightings an arc is continued: as many as tell a fall from a rest.

    A camera that is fast for the ball sees a bounce as a bend of a pixel a frame, which a course
    through few sightings would follow, and on into the ball's rest.
    """
    lasts_s = math.sqrt(SHOWN_AT_REST * tolerance(radius_px) / max(1e-9, abs(float(fall[0]))))
    step_s = float(np.median(np.diff(times_s)))
    frames = math.ceil(lasts_s / step_s) if step_s > 0.0 else MEMORY
    return min(MOST_REMEMBERED, max(MEMORY, frames))


class _Search:
    def __init__(
        self, seen: Sightings, radius_px: float, fall: Floats, free: list[NDArray[np.bool_]]
    ) -> None:
        frames, most = len(seen.places), max((len(each) for each in seen.places), default=0)
        self._seen, self._radius = seen, radius_px
        self._places = np.full((frames, most, 2), np.inf)
        self._free = np.zeros((frames, most), dtype=bool)
        for frame, places in enumerate(seen.places):
            self._places[frame, : len(places)] = places[:, :2]
            self._free[frame, : len(places)] = free[frame]
        self._rules = np.array(
            [
                tolerance(radius_px),
                MOST_SEED_RADII * radius_px,
                *map(float, seen.shape),
                float(_remembered(seen.times_s, radius_px, fall)),
                *fall.tolist(),
            ]
        )
        self._seed = np.zeros(3, dtype=np.intp)
        self._taken = np.zeros((frames, 2), dtype=np.intp)

    def best(self) -> Arc | None:
        """Return the next arc from the first seed that is left, and take its sightings."""
        known = self._seen.times_s, self._places, self._free, self._rules
        count = next_arc(known, self._seed, self._taken)
        if count == 0:
            return None
        return self._take([(int(k), int(i)) for k, i in self._taken[:count]])

    def goes_between(self, arc: Arc) -> bool:
        """Return whether an arc goes from one thing that stands still to another.

        What was at one of its places is still seen there while it is at others. Tolerances are so
        wide that some frames of two such things go through a fall.
        """
        chosen = np.unique(np.linspace(0, len(arc.frames) - 1, MOST_COMPARED).astype(np.intp))
        own, frames = arc.places[chosen], arc.frames[chosen]
        near = STILL_RADII * self._radius + STILL_PX
        apart = np.hypot(*np.moveaxis(own[:, None] - own[None], -1, 0)) > 2.0 * near
        every = self._places[frames]
        away = np.hypot(*np.moveaxis(own[:, None, None] - every[None], -1, 0)).min(axis=2)
        still = ((away < near) & apart).any(axis=1)
        return bool(still.sum() > MOST_STILL * len(own))

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

    def speeds(self, fall: Floats) -> tuple[Floats, Floats]:
        """Return the speeds (row, column) before and after each bounce, px/s, shapes (B, 2)."""
        before: list[Floats] = []
        after: list[Floats] = []
        for time, a, b in zip(self.times_s, self.arcs[:-1], self.arcs[1:], strict=True):
            for arc, end, speeds in ((a, True, before), (b, False, after)):
                middle, _, speed = arc.course(fall, end=end)
                speeds.append(speed + fall * (time - middle))
        return np.array(before).reshape(-1, 2), np.array(after).reshape(-1, 2)


def chains(arcs: Sequence[Arc], radius_px: float, fall: Floats) -> list[Chain]:
    """Return chains of arcs that meet in bounces, the strongest first; each arc is in one."""
    meetings = _meetings(arcs, radius_px, fall)
    meets = {j for each in meetings for j in each} | {k for k, each in enumerate(meetings) if each}
    best = [[k] for k in range(len(arcs)) if k not in meets]
    rest = sorted(meets)
    while rest:
        best.append(_strongest(arcs, rest, meetings))
        rest = [k for k in rest if k not in best[-1]]
    found = []
    for numbers in best:
        met = [meetings[k][j] for j, k in pairwise(numbers)]
        chain = Chain(
            tuple(arcs[k] for k in numbers),
            np.array([time for time, _ in met]),
            np.array([place for _, place in met]).reshape(-1, 2),
        )
        found.append(_parted(chain, radius_px, fall))
    return sorted(found, key=lambda chain: -chain.strength)


def _strongest(
    arcs: Sequence[Arc], rest: Sequence[int], meetings: Sequence[Mapping[int, Meeting]]
) -> list[int]:
    """Return the numbers of the arcs of the strongest chain of those that are left."""
    ends: dict[int, tuple[float, int | None]] = {}
    for k in rest:
        best: tuple[float, int | None] = arcs[k].strength, None
        for j in meetings[k]:
            if j in ends and ends[j][0] + arcs[k].strength > best[0]:
                best = ends[j][0] + arcs[k].strength, j
        ends[k] = best
    last: int | None = max(ends, key=lambda k: ends[k][0])
    chosen = []
    while last is not None:
        chosen.append(last)
        last = ends[last][1]
    return chosen[::-1]


def _meetings(arcs: Sequence[Arc], radius_px: float, fall: Floats) -> list[dict[int, Meeting]]:
    """Return when and where each arc meets earlier ones, by their numbers; not those it does not.

    Only what is near in time is looked at closely.
    """
    every = [_Followed.new(arc, radius_px, fall) for arc in arcs]
    rows = [(e.arc.frames[-1], e.arc.times_s[-1], e.step_s, e.over) for e in every]
    last, ends_s, steps_s, over = np.array(rows, dtype=np.float64).reshape(-1, 4).T
    found: list[dict[int, Meeting]] = []
    for k, later in enumerate(every):
        margins = _margin_s(steps_s[:k], np.maximum(over[:k], later.over))
        follows = later.arc.frames[0] > last[:k] - LEAST_FRAMES
        near = follows & (later.arc.times_s[0] - ends_s[:k] <= 4 * margins)
        each = {}
        for j in np.flatnonzero(near).tolist():
            meeting = _meeting(every[j], later, radius_px, fall)
            if meeting is not None:
                each[j] = meeting
        found.append(each)
    return found


def _parted(chain: Chain, radius_px: float, fall: Floats) -> Chain:
    """Return a chain whose arcs have the sightings on their own side of each bounce.

    Where a camera is fast for the ball its arcs go on over a bounce for some frames. Arcs between
    which frames lie keep what they have: those frames may be of a piece that belongs to neither.
    """
    arcs = list(chain.arcs)
    for k, time in enumerate(chain.times_s.tolist()):
        a, b = arcs[k : k + 2]
        beside = b.frames[0] - a.frames[-1] <= MOST_MISSES + 1
        if not (beside and _clear_of_bounces(a.times_s, radius_px, fall)[1]):
            continue
        own, under = (
            int(np.count_nonzero(a.times_s < time)),
            int(np.count_nonzero(b.times_s < time)),
        )
        if LEAST_FRAMES <= own < len(a.frames):
            arcs[k : k + 2] = a.part(0, own), _with(b, a.part(own, len(a.frames)))
        elif 0 < under <= len(b.frames) - LEAST_FRAMES:
            arcs[k : k + 2] = _with(a, b.part(0, under)), b.part(under, len(b.frames))
    return replace(chain, arcs=tuple(arcs))


def _with(own: Arc, other: Arc) -> Arc:
    """Return an arc with the sightings of another one in frames in which it has none."""
    whole = one_arc(own, other.of(np.flatnonzero(~np.isin(other.frames, own.frames))))
    return whole.of(np.argsort(whole.frames, kind="stable"))


def one_arc(a: Arc, b: Arc) -> Arc:
    """Return two arcs as one."""
    return Arc(
        np.concatenate([a.frames, b.frames]),
        np.concatenate([a.times_s, b.times_s]),
        np.concatenate([a.places, b.places]),
        a.strength + b.strength,
    )


def _clear_of_bounces(times_s: Floats, radius_px: float, fall: Floats) -> tuple[int, int]:
    """Return how many sightings next to a bounce give a course, and how many are left out.

    An arc goes on over a bounce until it lies a tolerance off.
    """
    remembered = _remembered(times_s, radius_px, fall)
    over = remembered // OVER_BOUNCE if remembered > MEMORY else 0
    return min(remembered + over, len(times_s)), min(over, max(0, len(times_s) - LEAST_FRAMES))


@dataclass(frozen=True, slots=True, eq=False)
class _Followed:
    """An arc, the time between its frames, and how many sightings next to a bounce count."""

    arc: Arc
    step_s: float
    last: int
    over: int

    @classmethod
    def new(cls, arc: Arc, radius_px: float, fall: Floats) -> _Followed:
        last, over = _clear_of_bounces(arc.times_s, radius_px, fall)
        return cls(arc, float(np.median(np.diff(arc.times_s))), last, over)


def _margin_s(step_s: Real, over: Real) -> Real:
    """Return how far beyond its sightings an arc may meet another, s."""
    return (MOST_MISSES + 1.5 + over) * step_s


def _meeting(before: _Followed, after: _Followed, radius_px: float, fall: Floats) -> Meeting | None:
    """Return when and where two courses meet in a bounce; None where they do not."""
    a, b = before.arc, after.arc
    margin = _margin_s(before.step_s, float(max(before.over, after.over)))
    at, place_a, velocity_a = a.course_of(slice(-before.last, -before.over or None), fall)
    bt, place_b, velocity_b = b.course_of(slice(after.over, after.last), fall)
    # Both at the time zero of the first: with the same fall their distance is linear in time.
    gone = at - bt
    place_b = place_b + velocity_b * gone + 0.5 * fall * gone**2
    velocity_b = velocity_b + fall * gone
    jump = velocity_b - velocity_a
    size = float(jump @ jump)
    if size <= 0 or np.sqrt(size) * before.step_s < 0.05:
        return None
    shift = -float((place_b - place_a) @ jump) / size
    apart = place_b - place_a + jump * shift
    came, left = (float((own + fall * shift) @ jump) for own in (velocity_a, velocity_b))
    down = float(jump @ fall) / max(1e-300, math.sqrt(size * float(fall @ fall)))
    if left > MOST_E * max(-came, 0.0) or down > MOST_DOWN:
        return None
    time = at + shift
    if not a.times_s[-1] - margin <= time <= b.times_s[0] + margin:
        return None
    beyond = math.sqrt(size) * float(max(a.times_s[-1] - time, time - b.times_s[0]))
    if max(float(np.hypot(*apart)), beyond) > MOST_APART_RADII * radius_px:
        return None
    return time, place_a + velocity_a * shift + 0.5 * fall * shift**2
