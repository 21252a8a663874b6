"""The flights of one ball among its sightings: they fall as its diameter says, or otherwise.

A stated diameter gives the scale of the picture, and with the film's rate how fast things fall in
it. People state a radius, or centimetres for millimetres, and a film in slow motion has the rate of
the player: what falls otherwise in one way throughout is the ball all the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from analysis.arrays import Floats
from analysis.balls.flight.known import Ball
from analysis.balls.found import CLEAR_FRAMES, MUCH_MORE, stated_first
from analysis.balls.gaps import Gap, mended
from analysis.balls.seen.arcs import Arc, Chain, Sightings, chains, find_arcs
from analysis.balls.seen.free_fall import (
    FALL_SHARE,
    agreeing,
    as_stated,
    bend_of,
    by_no_chance,
    falls,
    flown,
    flying,
)
from analysis.balls.seen.joining import joined
from analysis.balls.seen.jumps import jumps
from analysis.balls.seen.looks import Looks
from analysis.balls.seen.quarter_turns import places_turned

FALLS = (1.0, 0.7, 1.4, 0.5, 2.0)
"""Of the fall that follows from the stated diameter: those that are tried."""
NEAR_FALL, MOST_FALLS = 0.05, 8
"""Falls that differ by so little are one; and how many are tried."""
OTHER_FALLS = tuple(2.0**k for k in (*range(-2, -13, -1), *range(2, 9)))
"""Of that fall, what a diameter in another unit and a film in slow motion make of it: 1000 frames/s
that are shown at 25 fall 1600 times as slowly. Each is found from half of it to twice."""
MOST_UNSURE = 0.1
"""Error of another fall, as a share of it: of each flight that shows it, and of all."""
LEAST_OF_SEEN = 1 / 3
"""Of the frames in which the ball is seen: flights that fall otherwise."""

Flights = tuple[list[Chain], Chain, Floats]
"""Chains, the part of the strongest that the ball flies, and its fall."""


def stated_fall(ball: Ball, looks: Looks) -> Floats:
    """Return free fall in the picture by a ball's stated size, (row, column) in px/s^2."""
    return np.array([ball.gravity * 2 * looks.radius_px / ball.diameter_m, 0.0])


def turned(seen: Sightings, quarter_turns: int) -> Sightings:
    """Return what is seen in pictures that are turned by quarter turns, as by `np.rot90`."""
    places = [places_turned(each, seen.shape, quarter_turns) for each in seen.places]
    shape = seen.shape[::-1] if quarter_turns % 2 else seen.shape
    return replace(seen, places=places, shape=shape)


def falls_turned(seen: Sightings, looks: Looks, ball: Ball, quarter_turns: int) -> bool:
    """Return whether a ball flies where its picture is turned by quarter turns.

    Its discs and the places that look like it turn with the picture.
    """
    about, stated = turned(seen, quarter_turns), stated_fall(ball, looks)
    flights = flights_of(about, looks, stated)
    return flights is not None or without_jumps(about, looks, stated, None)[2] is not None


def without_jumps(
    seen: Sightings, looks: Looks, stated: Floats, flights: Flights | None
) -> tuple[Sightings, tuple[Gap, ...], Flights | None]:
    """Return sightings with times by which most of them are flights, gaps of these, and flights."""
    fall = stated if flights is None else flights[2]
    parted = chains(find_arcs(seen, looks.radius_px, fall), looks.radius_px, fall)
    arcs = sorted((arc for one in parted for arc in one.arcs), key=lambda arc: arc.times_s[0])
    gaps = tuple(jumps(seen, arcs, looks.radius_px, fall))
    while gaps:
        later = replace(seen, times_s=mended(seen.times_s, gaps))
        again = flights_of(later, looks, stated)
        if again is None or whole(again) < whole(flights):
            break
        if flights is not None and flights[2][0] == stated[0] != again[2][0]:
            # What falls as stated does not fall otherwise with the right times.
            break
        # What jumps before or after the ball's flights may be another thing.
        flown_in = np.concatenate([arc.frames for arc in again[1].arcs])
        inside = tuple(gap for gap in gaps if flown_in.min() < gap.frame <= flown_in.max())
        if inside == gaps:
            return later, gaps, again
        gaps = inside
    return seen, (), flights


def whole(flights: Flights | None) -> tuple[int, int]:
    """Return in how many frames a ball flies, and how few pieces that takes."""
    if flights is None:
        return 0, 0
    arcs = flights[1].arcs
    return sum(len(arc.frames) for arc in arcs), -len(arcs)


def flights_of(seen: Sightings, looks: Looks, stated: Floats) -> Flights | None:
    """Return chains of flights, the part of the strongest that the ball flies, and its fall.

    Where few flights bend as the stated diameter says, other falls are tried: a person may have
    stated a radius, or another rate; and as a clutter may have been taken for a part of the ball,
    the fall of the longest flight itself. Only flights that bend alike on both sides of a bounce
    count.
    """
    best: Flights | None = None
    own: list[Arc] = []
    most = as_said = 0
    shares = list(FALLS)
    for share in shares:
        fall = share * stated
        arcs = arcs_of(seen, looks, fall)
        if len(shares) < MOST_FALLS and (own_share := _of_longest(arcs, looks, stated)) is not None:
            near = any(abs(own_share / other - 1.0) < NEAR_FALL for other in shares)
            shares += [] if near else [own_share]
        flights = _linked(arcs, looks, fall, stated)
        if flights is None:
            continue
        frames, alike = agreeing(flights[1], looks, fall)
        clear = frames >= CLEAR_FRAMES and alike > 1
        as_said = frames if share == 1.0 else as_said
        # A larger fall follows a ball over lower bounces: that in which flights bend is right.
        enough = MUCH_MORE * most if share in FALLS else max(most, MUCH_MORE * as_said)
        if (share == 1.0 or clear) and (best is None or frames > enough):
            best, own, most = flights, arcs, frames
    if best is not None and _over_bounces(best, looks, stated):
        best = _linked(own, looks, stated, stated) or best
    return best


def arcs_of(seen: Sightings, looks: Looks, fall: Floats) -> list[Arc]:
    """Return pieces of free flight, those of one flight put together."""
    return joined(find_arcs(seen, looks.radius_px, fall), looks.radius_px, fall, seen.shape)


def _over_bounces(flights: Flights, looks: Looks, stated: Floats) -> bool:
    """Return whether flights bend as stated, and not by the fall with which they were found.

    A larger fall follows a ball over lower bounces.
    """
    _, chain, fall = flights
    if fall[0] == stated[0] or not as_stated(chain, looks, stated):
        return False
    bent = bend_of(chain.arcs, looks, fall)
    return bent is None or abs(bent[0] - 1.0) > NEAR_FALL


def _of_longest(arcs: Sequence[Arc], looks: Looks, stated: Floats) -> float | None:
    """Return the bend of the longest arc as a share of the stated fall, if it is well known.

    One far beyond the falls that are tried is another unit's or another rate's.
    """
    if not arcs:
        return None
    bent = bend_of([max(arcs, key=lambda arc: len(arc.frames))], looks, stated)
    if bent is None or not bent[1] < NEAR_FALL * bent[0]:
        return None
    return bent[0] if min(FALLS) < bent[0] < max(FALLS) else None


def _linked(arcs: Sequence[Arc], looks: Looks, fall: Floats, stated: Floats) -> Flights | None:
    """Return chains of arcs that fall, the part of the strongest that the ball flies, and its fall.

    None where no chain falls.
    """
    linked = [each for each in chains(arcs, looks.radius_px, fall) if falls(each, looks, fall)]
    if not linked:
        return None
    if np.array_equal(fall, stated):
        stated_first(linked, looks, fall)
    for k, each in enumerate(linked):
        # What a hand or a rest is taken from may have held the only sure flight.
        own = flown(flying(each, looks, fall), looks.radius_px)
        if by_no_chance(own, looks, fall):
            return [each, *linked[:k], *linked[k + 1 :]], own, fall
    return None


@dataclass(frozen=True, slots=True)
class OtherFall:
    """Flights that fall otherwise than a stated diameter and rate say.

    Attributes
    ----------
    share
        Of the fall that was stated.
    frames
        Number of those in which they do.
    first, last
        Frame, row and column where they begin and end.
    """

    share: float
    frames: int
    first: tuple[int, float, float]
    last: tuple[int, float, float]


def other_fall(
    seen: Sightings, looks: Looks, stated: Floats, flights: Flights | None
) -> OtherFall | None:
    """Return how a ball falls that falls far otherwise than stated; None where none surely does.

    At least two of its flights surely bend alike, in more frames than those of `flights`: a hand
    that moves a ball slowly to and fro goes through pieces of slow falls, of which hardly one shows
    its bend. Only the surest sighting of a frame is looked at.
    """
    seen = replace(seen, places=[places[:1] for places in seen.places])
    most = 0 if flights is None else agreeing(flights[1], looks, flights[2])[0]
    in_all = sum(len(places) > 0 for places in seen.places)
    least = max(CLEAR_FRAMES, LEAST_OF_SEEN * in_all, MUCH_MORE * most)
    if least > in_all:
        return None
    best: OtherFall | None = None
    for share in OTHER_FALLS:
        fall = share * stated
        other = _linked(arcs_of(seen, looks, fall), looks, fall, stated)
        if other is None:
            continue
        frames, alike = agreeing(other[1], looks, fall, MOST_UNSURE)
        bent = bend_of(other[1].arcs, looks, fall)
        if frames < least or alike < 2 or bent is None:
            continue
        if FALL_SHARE[0] < share * bent[0] < FALL_SHARE[1]:
            # A larger fall follows a ball that falls as stated over low bounces.
            continue
        if bent[1] < MOST_UNSURE * bent[0] and (best is None or frames > best.frames):
            ends = [
                (int(arc.frames[k]), *arc.places[k].tolist())
                for arc, k in ((other[1].arcs[0], 0), (other[1].arcs[-1], -1))
            ]
            best = OtherFall(share * bent[0], frames, ends[0], ends[1])
    return best
