"""Two spheres among the discs of a film's frames, by their motion and not by nearness.

Where spheres move by several radii from frame to frame, the nearest disc of the next frame may be
the other sphere. Any two discs of successive frames are a hypothesis of a free flight, which a
third confirms; it is grown forth and back as far as discs bear it out. Of all flights those four
are chosen, two before and two after, that meet in one contact: there the spheres touch, and where
the flights after it begin. Most discs borne out win.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats

Frames = NDArray[np.intp]

NEAR, NEAR_PX = 0.25, 2.0
"""Radii and pixels, whichever is more, from where a free flight predicts a disc."""
LEAST_DISCS = 3
MOST_MISSES = 2
LEADING = 5
LAST = slice(-LEADING, None)
"""Discs at the end of a flight that carry it on: longer ones bend by drag."""
LEAST_WAY = 1.0
"""Radii that a flight covers; less may be something that stands still."""
MOST_FLIGHTS = 16
TOUCH = 1.15
"""Of both radii: how near flights pass that may have touched, one above the other in depth."""
MEETING = 1.0
"""Radii of the smaller sphere between where it comes to the contact and where it leaves from."""
SLACK_FRAMES = 1.5
SAME_COLUMN = 0.5
"""Radii between the columns of both views."""

Places = Sequence[Floats]
"""Rows and columns of the discs of each frame, pixels, shape (discs, 2)."""


@dataclass(frozen=True, slots=True)
class Falling:
    """When a film's frames were taken, and what falls in them.

    Attributes
    ----------
    times_s
        Of the frames, s, shape (frames,).
    gravity_px
        By how much what flies gains rows, px/s^2.
    """

    times_s: Floats
    gravity_px: float

    def fallen(self, frames: Frames) -> Floats:
        """Return what gravity adds to (row, column), pixels, shape (frames, 2)."""
        drop = np.zeros((len(frames), 2))
        drop[:, 0] = 0.5 * self.gravity_px * self.times_s[frames] ** 2
        return drop


@dataclass(frozen=True, slots=True, eq=False)
class Flight:
    """Discs on one free flight: their frames, shape (n,), and places, pixels, shape (n, 2)."""

    frames: Frames
    places: Floats

    def line(self, chosen: slice, falling: Falling) -> tuple[Floats, Floats]:
        """Return place and velocity at time 0 of some discs' flight, gravity taken out."""
        frames = self.frames[chosen]
        straight, times = self.places[chosen] - falling.fallen(frames), falling.times_s[frames]
        away = times - times.mean()
        velocity = away @ straight / (away @ away)
        return straight.mean(axis=0) - velocity * times.mean(), velocity

    def at(self, frame: int, falling: Falling) -> Floats:
        """Return the place in any frame, from the discs that are nearest in time."""
        near = np.searchsorted(self.frames, frame)
        first = int(np.clip(near - LEADING // 2, 0, max(len(self.frames) - LEADING, 0)))
        place, velocity = self.line(slice(first, first + LEADING), falling)
        fallen = falling.fallen(np.array([frame]))[0]
        return np.asarray(place + velocity * falling.times_s[frame] + fallen)


def free_flights(places: Places, radius: float, falling: Falling) -> list[Flight]:
    """Return all free flights of discs of a radius, pixels, those with most discs first."""
    reach, taken = max(NEAR * radius, NEAR_PX), set[tuple[int, int, int]]()
    found: list[Flight] = []
    for k in range(len(places) - LEAST_DISCS + 1):
        for i, j in itertools.product(range(len(places[k])), range(len(places[k + 1]))):
            if (k, i, j) in taken:
                continue
            flight, own = _grown((k, i, j), places, reach, falling)
            taken |= own
            way = np.hypot(*(flight.places[-1] - flight.places[0]))
            if len(flight.frames) >= LEAST_DISCS and way > LEAST_WAY * radius:
                found.append(flight)
    return sorted(found, key=lambda flight: -len(flight.frames))


def _grown(
    start: tuple[int, int, int], places: Places, reach: float, falling: Falling
) -> tuple[Flight, set[tuple[int, int, int]]]:
    """Return the flight through two discs of successive frames, and all such pairs within it."""
    k, i, j = start
    chosen = {k: i, k + 1: j}
    for direction in (1, -1):
        misses, frame = 0, k + 2 if direction == 1 else k - 1
        while 0 <= frame < len(places) and misses < MOST_MISSES:
            predicted = _flight(chosen, places).at(frame, falling)
            off = np.hypot(*(places[frame] - predicted).T)
            misses += 1
            if off.size and off.min() < reach:
                chosen[frame], misses = int(off.argmin()), 0
            frame += direction
        _drop_lone(chosen, direction)
    pairs = {(f, n, chosen[f + 1]) for f, n in chosen.items() if f + 1 in chosen}
    return _flight(chosen, places), pairs


def _drop_lone(chosen: dict[int, int], direction: int) -> None:
    """Take away a disc at an end, beyond a frame without: it may be of the other sphere."""
    last = max(chosen) if direction == 1 else min(chosen)
    if last - direction not in chosen:
        del chosen[last]


def _flight(chosen: dict[int, int], places: Places) -> Flight:
    frames = sorted(chosen)
    return Flight(np.array(frames), np.array([places[f][chosen[f]] for f in frames]))


Four = tuple[tuple[Flight, Flight], tuple[Flight, Flight]]
"""Of sphere a before and after the contact, and of b."""


def within(places: Floats, rows: tuple[float, float]) -> Floats:
    """Return the places in some rows, given the first and the one after the last."""
    return places[(rows[0] <= places[:, 0]) & (places[:, 0] < rows[1])]


def meeting(
    places: tuple[Places, Places],
    rows: tuple[float, float],
    radii: tuple[float, float],
    falling: Falling,
) -> Four | None:
    """Return the flights of both spheres that one contact joins; None where none does.

    Parameters
    ----------
    places
        In the whole picture, of discs as large as a, and as b; the same ones for spheres alike, of
        which a is then the one that comes from the left.
    rows
        Of the front view, the first and the one after the last. Both spheres come there; what flies
        off may rise into the rows of the mirror's view.
    radii
        Of a and b, pixels.
    """
    alike = places[0] is places[1]
    a, b = ([within(own, rows) for own in every] for every in places)
    coming = _flights((a, b), radii, falling, alike)
    going = _flights(places, radii, falling, alike)
    best: tuple[int, Four] | None = None
    for pair in itertools.product(*(own[:MOST_FLIGHTS] for own in coming)):
        first, second = pair
        if first is second or (alike and first.places[0, 1] > second.places[0, 1]):
            continue
        touch = _touch(first, second, sum(radii), falling)
        if touch is None:
            continue
        after = [
            [flight for flight in own if _leaves(flight, before, touch, radius, falling)]
            for own, before, radius in zip(going, pair, radii, strict=True)
        ]
        for c, d in itertools.product(*after):
            count = sum(len(each.frames) for each in (*pair, c, d))
            if c is not d and (best is None or count > best[0]):
                best = count, ((first, c), (second, d))
    return None if best is None else best[1]


def _flights(
    places: tuple[Places, Places], radii: tuple[float, float], falling: Falling, alike: bool
) -> tuple[list[Flight], list[Flight]]:
    """Return the flights of discs as large as a, and as b."""
    a = free_flights(places[0], radii[0], falling)
    return a, a if alike else free_flights(places[1], radii[1], falling)


Course = tuple[Floats, Floats]
"""Place and velocity at time 0, gravity taken out, pixels and pixels a second."""


def _closest(courses: tuple[Course, Course], reach: float) -> float | None:
    """Return when two courses come within a reach of each other, s; None if never."""
    (at_a, v_a), (at_b, v_b) = courses
    apart, closing = at_b - at_a, v_b - v_a
    speed2 = float(closing @ closing)
    if speed2 == 0.0:
        return None
    nearest = -float(apart @ closing) / speed2
    miss2 = float(((apart + closing * nearest) ** 2).sum())
    if miss2 > (TOUCH * reach) ** 2:
        return None
    return nearest - float(np.sqrt(max(reach**2 - miss2, 0.0) / speed2))


def _touch(a: Flight, b: Flight, reach: float, falling: Falling) -> float | None:
    """Return when two flights, carried on beyond their ends, come to touch, s; None if never."""
    touch = _closest((a.line(LAST, falling), b.line(LAST, falling)), reach)
    if touch is None:
        return None
    slack = SLACK_FRAMES * float(np.median(np.diff(falling.times_s)))
    ends = [falling.times_s[own.frames[-1]] for own in (a, b)]
    return touch if max(ends) < touch + slack else None


def _leaves(after: Flight, before: Flight, touch_s: float, radius: float, falling: Falling) -> bool:
    """Tell whether a flight begins where another is at the touch."""
    slack = SLACK_FRAMES * float(np.median(np.diff(falling.times_s)))
    if falling.times_s[after.frames[0]] < touch_s - slack:
        return False
    place, velocity = after.line(slice(LEADING), falling)
    came, speed = before.line(LAST, falling)
    off = place - came + (velocity - speed) * touch_s
    return bool(np.hypot(*off) < MEETING * radius)


def mirrored(
    four: Four, places: Sequence[Places], radii: tuple[float, float], shift: float, falling: Falling
) -> tuple[list[Flight], list[Flight]]:
    """Return the discs of a and of b in the mirror's view, one flight or two of each.

    Where both are seen before the contact, what is seen after it begins where they touch: spheres
    that are near each other there have like columns, and either one's disc lies in the other's.
    What flies off toward the camera may show one disc there after contact, which no other bears
    out. It is the sphere's where its columns hold no second one, and the other sphere's not it.

    Parameters
    ----------
    places
        In the mirror's view, of discs as large as a, and as b.
    shift
        What is added to a column of the front view, pixels.
    """

    def seen_of(i: int, flight: Flight) -> Seen:
        return _in_columns(flight, places[i], SAME_COLUMN * radii[i], shift)

    reaches = [max(NEAR * radius, NEAR_PX) for radius in radii]
    came = [
        _on_a_line(seen_of(i, before), reach, falling)
        for i, ((before, _), reach) in enumerate(zip(four, reaches, strict=True))
    ]
    begins = _mirrored_touch((four[0][0], four[1][0]), came, sum(radii), falling)
    found: tuple[list[Flight], list[Flight]] = ([], [])
    for i, (_, after) in enumerate(four):
        seen, other = seen_of(i, after), four[1 - i][1]
        left = _on_a_line(seen, reaches[i], falling, begins[i])
        if left is None and len(seen) == 1:
            ((k, row, column),) = seen
            apart = abs(other.at(k, falling)[1] + shift - column)
            if apart > SAME_COLUMN * (radii[0] + radii[1]):
                left = Flight(np.array([k]), np.array([(row, column)]))
        found[i].extend(own for own in (came[i], left) if own is not None)
    return found


Seen = list[tuple[int, float, float]]
"""Frame, row and column of discs."""
Begin = tuple[float, float] | None
"""Time, s, and row in the mirror's view in which a flight after the contact begins; None: open."""


def _mirrored_touch(
    before: tuple[Flight, Flight], came: Sequence[Flight | None], reach: float, falling: Falling
) -> tuple[Begin, Begin]:
    """Return where both spheres touch in the mirror's view, by what it shows of them before.

    Parameters
    ----------
    before
        Flights of a and b in the front view.
    came
        The same in the mirror's view; None where it does not show one.
    reach
        Distance of the centres at touch, pixels.
    """
    a, b = came
    if a is None or b is None:
        return None, None
    heights = _height(a, falling), _height(b, falling)

    def in_space(flight: Flight, height: tuple[float, float]) -> Course:
        place, velocity = flight.line(LAST, falling)
        return np.append(place, height[0]), np.append(velocity, height[1])

    touch = _closest((in_space(before[0], heights[0]), in_space(before[1], heights[1])), reach)
    if touch is None:
        return None, None
    first, second = (row + slope * touch for row, slope in heights)
    return (touch, first), (touch, second)


def _height(mirrored: Flight, falling: Falling) -> tuple[float, float]:
    """Return row and its rate at time 0 of discs in the mirror's view, in which nothing falls."""
    times, rows = falling.times_s[mirrored.frames[LAST]], mirrored.places[LAST, 0]
    slope, row = np.polyfit(times, rows, 1)
    return float(row), float(slope)


def _in_columns(flight: Flight, places: Places, reach: float, shift: float) -> Seen:
    seen = []
    for k, (_, column) in zip(flight.frames.tolist(), flight.places.tolist(), strict=True):
        for row, other in places[k].tolist():
            if abs(other - column - shift) < reach:
                seen.append((k, row, other))
    return seen


def _on_a_line(seen: Seen, reach: float, falling: Falling, begin: Begin = None) -> Flight | None:
    """Return those discs whose rows lie on one straight line, two at least."""
    best: Seen = []
    times = falling.times_s
    for (k, row, _), (m, other, _) in itertools.combinations(seen, 2):
        if k == m:
            continue
        slope = (other - row) / (times[m] - times[k])
        if begin is not None and abs(row + slope * (begin[0] - times[k]) - begin[1]) > reach:
            continue
        borne = {
            n: (n, r, c) for n, r, c in seen if abs(r - row - slope * (times[n] - times[k])) < reach
        }
        if len(borne) > len(best):
            best = list(borne.values())
    if not best:
        return None
    return Flight(np.array([k for k, _, _ in best]), np.array([at for _, *at in best]))


def guide(four: Four, falling: Falling) -> Floats:
    """Return row and column of a and b in the frames between the ends of their flights.

    Returns
    -------
    Shape (2, frames, 2); not a number in the other frames.
    """
    places = np.full((2, len(falling.times_s), 2), np.nan)
    for i, (before, after) in enumerate(four):
        for own in (before, after):
            for k in range(int(own.frames[0]), int(own.frames[-1]) + 1):
                seen = np.flatnonzero(own.frames == k)
                places[i, k] = own.places[seen[0]] if seen.size else own.at(k, falling)
    return places
