"""What a person should know of a ball before its flights, after them, and at the border."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.flight.flights import LEAST_PLACES, Flights
from analysis.balls.gaps import frame_at, period_of
from analysis.balls.measuring import MeasuredBall
from analysis.balls.seen.arcs import Arc
from analysis.errors import counted

NEAR_RADII = 1.6
LOW_BOUNCE = 0.2
"""Of a radius: rows that differ by more at the plate are those of a ball that bounces."""
RISES = 0.1
"""Radii by which a ball is higher at the film's end than after its bounce."""
STAYS_RADII = 1.0
"""What is held moves by less."""
QUICK = 0.05  # Radii a frame: what is held at the picture's border moves less.
FOLLOWED = 4.0
"""Frames from the last place of a flight to the bounce that ends it: seen up to there."""


def edges(measured: MeasuredBall) -> Iterator[str]:
    """Say where the ball enters or leaves the picture, and where the film begins or ends."""
    head, chain = measured.head, measured.chain
    for arc, index, word in ((chain.arcs[0], 0, "enters"), (chain.arcs[-1], -1, "leaves")):
        frame = int(arc.frames[index])
        at_the_film_s_end = frame in (0, head.frames - 1)
        if _goes_out(measured, arc, index) and not at_the_film_s_end:
            yield f"the ball {word} the picture at frame {frame} {place_of(arc, index)}"
        elif at_the_film_s_end and word == "leaves" and len(arc.frames) < 2 * LEAST_PLACES:
            yield f"the film ends at frame {frame}, soon after a bounce, {place_of(arc, index)}"
    gaps = [
        (int(a), int(b))
        for arc in chain.arcs
        for a, b in zip(arc.frames[:-1], arc.frames[1:], strict=True)
        if b - a > LEAST_PLACES
    ]
    for a, b in gaps:
        yield f"the ball is not seen between frames {a} and {b}: it is hidden or out of the picture"
    for bounce, (before, after) in enumerate(pairwise(chain.arcs), start=1):
        a, b = int(before.frames[-1]), int(after.frames[0])
        if b - a > LEAST_PLACES:
            yield (
                f"the ball is not followed from frame {a + 1} to frame {b - 1}, about bounce "
                f"{bounce}, between {place_of(before, -1)[3:]} and {place_of(after, 0)[3:]}: it is "
                "hidden, or looks otherwise there; these frames have no place"
            )


def _goes_out(measured: MeasuredBall, arc: Arc, index: int) -> bool:
    """Return whether the ball is about to cross a border of the picture, or has just come in.

    Below the plate it does not go, nor where it is seen outside its flights just before or after.
    """
    if len(arc.frames) < 2:
        return False
    radius = measured.looks.radius_px
    place, step = _outward(arc, index)
    seen = measured.search.unexplained
    beside = seen[np.abs(seen[:, 0] - arc.frames[index]) < LEAST_PLACES, 1:] - place
    if (np.hypot(*beside.T) < NEAR_RADII * radius + LEAST_PLACES * np.hypot(*step)).any():
        return False
    plate = measured.chain.places[:, 0].max(initial=-np.inf)
    height = measured.head.height
    bottom = height if plate + radius > height or plate < 0 else np.inf
    room = _room(measured, place)
    room[2] = bottom - place[0]
    outward = np.concatenate([-step, step])
    return bool(((outward > 0) & (room < NEAR_RADII * radius + outward)).any())


def _passed(measured: MeasuredBall, places: Floats) -> bool:
    """Return whether the border cuts the ball, at some places, to which its last flight has gone.

    What is left of it in the picture moves more slowly than the ball.
    """
    last = measured.chain.arcs[-1]
    if len(last.frames) < 2:
        return False
    end, step = _outward(last, -1)
    radius = measured.looks.radius_px
    quick = np.concatenate([-step, step]) > QUICK * radius
    near = [_room(measured, place) < NEAR_RADII * radius for place in (end, *places)]
    return bool((quick & np.all(near, axis=0)).any())


def _outward(arc: Arc, index: int) -> tuple[Floats, Floats]:
    """Return where a flight begins (0) or ends (-1), and the step that leads out of it there."""
    inner = 1 if index == 0 else -2
    return arc.places[index], arc.places[index] - arc.places[inner]


def _room(measured: MeasuredBall, place: Floats) -> Floats:
    """Return how far a place is from the picture's upper, left, lower and right side, px."""
    head, (row, column) = measured.head, place
    return np.array([row, column, head.height - row, head.width - column])


def outside(measured: MeasuredBall) -> Iterator[str]:
    """Say where the ball is seen before its first flight or after its last."""
    chain, seen = measured.chain, measured.search.unexplained
    first, last = chain.arcs[0].frames[0], chain.arcs[-1].frames[-1]
    last_of_film = measured.head.frames - LEAST_PLACES
    for when, own in (("before", seen[seen[:, 0] < first]), ("after", seen[seen[:, 0] > last])):
        if len(own) < LEAST_PLACES:
            continue
        start, end = np.median(own[:3, 1:], axis=0), np.median(own[-3:, 1:], axis=0)
        down, across = abs(end[0] - start[0]), abs(end[1] - start[1])
        radius = measured.looks.radius_px
        moves = across > max(2 * down, 0.5 * radius)
        stays = max(down, across, 0.5 * np.ptp(own[:, 1])) < STAYS_RADII * radius
        does = "rolls or is carried" if moves else "is held or rests" if stays else "moves"
        if len(chain.places) and (np.abs(own[:, 1] - chain.places[-1, 0]) < radius).all():
            does = "rolls along the plate" if moves else "rests on the plate"
            if np.ptp(own[:, 1]) > LOW_BOUNCE * radius:
                does = "bounces too low to be measured"
            if own[-1, 0] >= last_of_film and start[0] - end[0] > RISES * radius:
                does = "rises by less than a radius until the film ends, too little to be measured"
        if when == "after" and stays and _passed(measured, own[:, 1:]):
            does = "is cut by the picture's border"
        # It crosses no border along which it moves.
        size = measured.head.width if across > down else measured.head.height
        cut = [min(at, size - at) < radius for at in own[[0, -1], 2 if across > down else 1]]
        if cut[0] != cut[1] and math.hypot(down, across) > QUICK * radius * len(own):
            does = "enters the picture" if cut[0] else "leaves the picture"
        yield (
            f"{when} its flights, in frames {own[0, 0]:.0f} to {own[-1, 0]:.0f}, the ball or what "
            f"looks like it {does}: from ({start[0]:.0f}, {start[1]:.0f}) to ({end[0]:.0f}, "
            f"{end[1]:.0f}) px; these frames do not count"
        )


def hands(measured: MeasuredBall) -> Iterator[str]:
    """Say where the ball looks or moves otherwise at both ends of its flights: hands let it go.

    Over its own shadow at the plate, and cut by the picture's border, it looks otherwise too.
    """
    placed = measured.placed.frames
    first, last = measured.chain.arcs[0], measured.chain.arcs[-1]
    for arc, out in ((first, first.frames < placed[0]), (last, last.frames > placed[-1])):
        own = np.flatnonzero(out & _whole(measured, arc))
        if len(own) >= LEAST_PLACES:
            a, b = own[[0, -1]]
            yield (
                f"from frame {arc.frames[a]} {place_of(arc, a)} to frame {arc.frames[b]} "
                f"{place_of(arc, b)} the ball does not look or fly as it does in the others: a "
                "hand is at it, something is in front of it, frames are missing, or the film's "
                "rate varies; these frames do not count"
            )


def _whole(measured: MeasuredBall, arc: Arc) -> NDArray[np.bool_]:
    """Return in which frames of an arc the ball is clear of the plate and of the border."""
    reach = NEAR_RADII * measured.looks.radius_px
    sides = np.array([measured.head.height, measured.head.width])
    inside = (arc.places > reach).all(axis=1) & (arc.places < sides - reach).all(axis=1)
    plate = measured.chain.places[:, 0]
    apart = np.abs(arc.places[:, :1] - plate).min(axis=1, initial=np.inf)
    return np.asarray(inside & (apart > reach))


def one_more(measured: MeasuredBall, flights: Flights) -> Iterator[str]:
    """Say where and why a bounce that ends the last flight is not measured."""
    head, radius = measured.head, measured.looks.radius_px
    time = flights.next_contact_s
    latest = max(float(own.contacts[-1, 0]) for _, own in measured.surfaces)
    if flights.off_a_wall or latest > flights.contacts[-1, 0]:
        return
    row, column, _ = flights.at(np.array([time]), np.array([flights.bounces]))[0]
    delay = float(flights.row_delay(np.array([[row, column]]))[0])
    frame = frame_at(measured.times_s, time - delay)
    last = head.frames - 1
    own = flights.observed.frames[flights.arcs == flights.bounces]
    if frame > last + 0.5 or frame - own.max(initial=0) > FOLLOWED:
        return
    arcs = measured.chain.arcs
    places = np.concatenate([np.column_stack([a.frames, a.places]) for a in arcs])
    seen = np.concatenate([places, measured.search.unexplained])
    after = seen[seen[:, 0] > frame]
    left = max(0, int(last - math.floor(frame + 0.5)))
    short = flights.lasts_after_next_s / period_of(measured.times_s)
    if left < LEAST_PLACES:
        why = (
            f"the film ends {counted(left, 'frame')} after it, at frame {last}; {LEAST_PLACES} are "
            "needed"
        )
    elif not len(after):
        why = "the ball is not seen after it"
    elif (row - after[:, 1] < radius).all():
        why = (
            f"until frame {after[:, 0].max():.0f} the ball stays over its shadow at the plate, "
            "where places are off: it bounces too low, rolls or rests"
        )
    elif short < LEAST_PLACES + 2.0:
        why = (
            f"the flight after it lasts some {short:.1f} frames, too few to be measured at this "
            "frame rate"
        )
    elif left < 2 * LEAST_PLACES:
        why = (
            f"the film ends {counted(left, 'frame')} after it, at frame {last}, and fewer than "
            f"{LEAST_PLACES} of these are clear of the contact and in one flight"
        )
    else:
        why = (
            "no free flight that fits its time follows it: frames are missing, or the ball is "
            "caught, hidden, or out of the picture"
        )
    number = 1 + sum(own.bounces for _, own in measured.surfaces)
    yield (
        f"bounce {number}, at about frame {frame:.1f} and ({row:.0f}, {column:.0f}) "
        f"px, is not measured: {why}"
    )


def place_of(arc: Arc, index: int) -> str:
    """Say where a ball is in a frame of its flight."""
    row, column = arc.places[index]
    return f"at ({row:.0f}, {column:.0f}) px"
