"""What a person should know of a film: sentences with frame and place."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from analysis.balls.doubts import doubts
from analysis.balls.films.film import FilmHead
from analysis.balls.flight.flights import LEAST_PLACES, MOST_LEFT_OUT, Flights
from analysis.balls.gaps import frame_at, period_of
from analysis.balls.measuring import MeasuredBall
from analysis.balls.seen.arcs import Arc, Chain
from analysis.errors import counted

NEAR_RADII = 1.6
LOW_BOUNCE = 0.2
"""Of a radius: rows that differ by more at the plate are those of a ball that bounces."""
QUICK = 0.05  # Radii a frame: what is held at the picture's border moves less.
FOLLOWED = 4.0
"""Frames from the last place of a flight to the bounce that ends it: seen up to there."""
CONTACT_FRAMES = 0.6
"""Frames beside a contact, and half the exposure, in which places may show part of it."""
FEW_GAPS = 2
"""Places at which a film lacks frames whose rate holds."""
SHOWN = 12
"""Frames that a sentence lists."""


def remarks(measured: MeasuredBall) -> tuple[str, ...]:
    """Return the sentences of one film, none where nothing is out of the ordinary."""
    return tuple(_remarks(measured))


def _remarks(measured: MeasuredBall) -> Iterator[str]:
    head, chain = measured.head, measured.chain
    yield from head.notes
    yield from (_other(*other) for other in measured.search.others)
    yield from _missing(measured)
    yield from _edges(measured)
    yield from _repeated(measured)
    yield from _outside(measured)
    if len(measured.placed.frames):
        yield from _hands(measured)
    if measured.flights is None:
        arc = chain.arcs[0]
        yield (
            f"no bounce: the ball flies from frame {arc.frames[0]} {_at(arc, 0)} to frame "
            f"{arc.frames[-1]} {_at(arc, -1)} without a second flight that meets the first; if it "
            "bounces there, frames are missing, or the film's rate varies without times of its own"
        )
        return
    yield from _one_more(measured, measured.flights)
    yield from _of_flights(measured.flights, head)
    yield from _do_not_count(measured, measured.flights)
    yield from doubts(measured, measured.flights)


def _other(other: Chain, is_round: bool) -> str:
    arc = other.arcs[0]
    what = "another ball flies" if is_round else "something else moves"
    return (
        f"{what} in frames {arc.frames[0]} to "
        f"{other.arcs[-1].frames[-1]}, first {_at(arc, 0)}; it is left out"
    )


def _missing(measured: MeasuredBall) -> Iterator[str]:
    """Say where frames are missing, and what was done about it."""
    period = period_of(measured.times_s)
    arcs = measured.chain.arcs
    frames = np.concatenate([arc.frames for arc in arcs])
    places = np.concatenate([arc.places for arc in arcs])
    for gap in measured.gaps:
        row, column = places[int(np.argmin(np.abs(frames - gap.frame)))]
        yield (
            f"{counted(gap.count, 'frame')} seem{'s' * (gap.count == 1)} to be missing before "
            f"frame {gap.frame}, at ({row:.0f}, {column:.0f}) px: there the ball goes on as if it "
            f"were {counted(gap.count, 'frame')} later; the times of this frame and of those after "
            f"it were set {1e3 * gap.count * period:.3g} ms later, and frame numbers count the "
            "frames that are there"
        )
    if len(measured.gaps) > FEW_GAPS:
        first, last = measured.gaps[0].frame, measured.gaps[-1].frame
        (a, b), (c, d) = (places[int(np.argmin(np.abs(frames - at)))] for at in (first, last))
        yield (
            f"where frames seem to be missing at {len(measured.gaps)} places, from frame {first} "
            f"at ({a:.0f}, {b:.0f}) px to frame {last} at ({c:.0f}, {d:.0f}) px, it may be that "
            "the film's rate varies and its times do not say so"
        )
    if measured.more_gaps:
        yield (
            f"frames seem to be missing at more places than the {len(measured.gaps)} whose times "
            "were mended: the film's times are not to be believed, and e may be further off than "
            "its error says; state the film that the camera wrote, or a part of it with --frames"
        )


def _repeated(measured: MeasuredBall) -> Iterator[str]:
    """Say which frames of the flights show a picture twice."""
    arcs = measured.chain.arcs
    inside = [k for k in measured.search.repeated if arcs[0].frames[0] < k < arcs[-1].frames[-1]]
    if inside:
        yield (
            f"{counted(len(inside), 'frame')} of the flights show the picture before them once "
            f"more ({_listed(inside)}): the film was brought to another rate, or its rate varies; "
            "they do not count, and the times of the others may be off by a part of a frame"
        )


def _outside(measured: MeasuredBall) -> Iterator[str]:
    """Say where the ball is seen before its first flight or after its last."""
    chain, seen = measured.chain, measured.search.unexplained
    first, last = chain.arcs[0].frames[0], chain.arcs[-1].frames[-1]
    for when, own in (("before", seen[seen[:, 0] < first]), ("after", seen[seen[:, 0] > last])):
        if len(own) < LEAST_PLACES:
            continue
        start, end = np.median(own[:3, 1:], axis=0), np.median(own[-3:, 1:], axis=0)
        down, across = abs(end[0] - start[0]), abs(end[1] - start[1])
        radius = measured.looks.radius_px
        moves = across > max(2 * down, 0.5 * radius)
        does = "rolls or is carried" if moves else "is held or rests"
        if len(chain.places) and (np.abs(own[:, 1] - chain.places[-1, 0]) < radius).all():
            does = "rolls along the plate" if moves else "rests on the plate"
            if np.ptp(own[:, 1]) > LOW_BOUNCE * radius:
                does = "bounces too low to be measured"
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


def _hands(measured: MeasuredBall) -> Iterator[str]:
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
                f"from frame {arc.frames[a]} {_at(arc, a)} to frame {arc.frames[b]} {_at(arc, b)} "
                "the ball does not look or fly as it does in the others: a hand is at it, "
                "something is in front of it, frames are missing, or the film's rate varies; these "
                "frames do not count"
            )


def _whole(measured: MeasuredBall, arc: Arc) -> NDArray[np.bool_]:
    """Return in which frames of an arc the ball is clear of the plate and of the border."""
    reach = NEAR_RADII * measured.looks.radius_px
    sides = np.array([measured.head.height, measured.head.width])
    inside = (arc.places > reach).all(axis=1) & (arc.places < sides - reach).all(axis=1)
    plate = measured.chain.places[:, 0]
    apart = np.abs(arc.places[:, :1] - plate).min(axis=1, initial=np.inf)
    return np.asarray(inside & (apart > reach))


def _listed(frames: list[int]) -> str:
    """Return numbers with commas, the first of many."""
    more = f" and {len(frames) - SHOWN} more" if len(frames) > SHOWN else ""
    return ", ".join(map(str, frames[:SHOWN])) + more


def _at(arc: Arc, index: int) -> str:
    row, column = arc.places[index]
    return f"at ({row:.0f}, {column:.0f}) px"


def _edges(measured: MeasuredBall) -> Iterator[str]:
    """Say where the ball enters or leaves the picture, and where the film begins or ends."""
    head, chain = measured.head, measured.chain
    for arc, index, word in ((chain.arcs[0], 0, "enters"), (chain.arcs[-1], -1, "leaves")):
        frame = int(arc.frames[index])
        at_the_film_s_end = frame in (0, head.frames - 1)
        if _goes_out(measured, arc, index) and not at_the_film_s_end:
            yield f"the ball {word} the picture at frame {frame} {_at(arc, index)}"
        elif at_the_film_s_end and word == "leaves" and len(arc.frames) < 2 * LEAST_PLACES:
            yield f"the film ends at frame {frame}, soon after a bounce, {_at(arc, index)}"
    gaps = [
        (int(a), int(b))
        for arc in chain.arcs
        for a, b in zip(arc.frames[:-1], arc.frames[1:], strict=True)
        if b - a > LEAST_PLACES
    ]
    for a, b in gaps:
        yield f"the ball is not seen between frames {a} and {b}: it is hidden or out of the picture"


def _goes_out(measured: MeasuredBall, arc: Arc, index: int) -> bool:
    """Return whether the ball is about to cross a border of the picture, or has just come in.

    Below the plate it does not go, nor where it is seen outside its flights just before or after.
    """
    if len(arc.frames) < 2:
        return False
    head, radius = measured.head, measured.looks.radius_px
    inner = 1 if index == 0 else -2
    place, step = arc.places[index], arc.places[index] - arc.places[inner]
    seen = measured.search.unexplained
    beside = seen[np.abs(seen[:, 0] - arc.frames[index]) < LEAST_PLACES, 1:] - place
    if (np.hypot(*beside.T) < NEAR_RADII * radius + LEAST_PLACES * np.hypot(*step)).any():
        return False
    plate = measured.chain.places[:, 0].max(initial=-np.inf)
    bottom = head.height if plate + radius > head.height or plate < 0 else np.inf
    room = np.array([place[0], place[1], bottom - place[0], head.width - place[1]])
    outward = np.concatenate([-step, step])
    return bool(((outward > 0) & (room < NEAR_RADII * radius + outward)).any())


def _one_more(measured: MeasuredBall, flights: Flights) -> Iterator[str]:
    """Say where and why a bounce that ends the last flight is not measured."""
    head, radius = measured.head, measured.looks.radius_px
    time = flights.next_contact_s
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
    else:
        why = (
            "no free flight that fits its time follows it: frames are missing, or the ball is "
            "caught, hidden, or out of the picture"
        )
    yield (
        f"bounce {flights.bounces + 1}, at about frame {frame:.1f} and ({row:.0f}, {column:.0f}) "
        f"px, is not measured: {why}"
    )


def _do_not_count(measured: MeasuredBall, flights: Flights) -> Iterator[str]:
    """Name the frames of the flights that do not count, by reason."""
    frames = flights.observed.frames
    times = flights.observed.times_s + flights.row_delay(flights.observed.places)
    period = period_of(measured.times_s)
    near = 0.5 * measured.exposure_s + CONTACT_FRAMES * period
    contacts = np.append(flights.contacts[:, 0], flights.next_contact_s)
    touching = (np.abs(times[:, None] - contacts).min(axis=1) < near) | (times > contacts[-1])
    for which, why in (
        (~flights.used & touching, "exposed during a contact, or next to one"),
        (~flights.used & ~touching, "off the flights"),
    ):
        if which.any():
            listed = ", ".join(str(int(frame)) for frame in frames[which])
            yield f"frames that do not count ({why}): {listed}"


def _of_flights(flights: Flights, head: FilmHead) -> Iterator[str]:
    fall, fall_sigma = flights.scale_of_fall
    size, size_sigma = flights.scale_of_diameter
    if flights.contradiction:
        ratio = size / fall
        yield (
            f"the diameter contradicts gravity: by its fall the ball is {ratio:.3f} ± "
            f"{ratio * math.hypot(fall_sigma, size_sigma):.3f} times as large as stated; "
            "speeds are scaled by gravity, e does not depend on it; check the diameter, the frame "
            "rate and that the camera sees the flight from the side"
        )
    for bounce in range(flights.bounces):
        after = int(np.count_nonzero(flights.used & (flights.arcs == bounce + 1)))
        before = int(np.count_nonzero(flights.used & (flights.arcs == bounce)))
        if min(after, before) < LEAST_PLACES:
            yield (
                f"bounce {bounce + 1} has {before} frames before and {after} after it; "
                f"{LEAST_PLACES} are needed for an error that can be trusted"
            )
    left_out = [int(f) for f in flights.observed.frames[~flights.used]]
    if len(left_out) > MOST_LEFT_OUT * len(flights.used):
        out = np.flatnonzero(~flights.used)
        (a, b), (c, d) = flights.observed.places[out[[0, -1]]]
        yield (
            f"{len(left_out)} of {len(flights.used)} places lie off free flights, from frame "
            f"{left_out[0]} at ({a:.0f}, {b:.0f}) px to frame {left_out[-1]} at ({c:.0f}, {d:.0f}) "
            "px: the film's rate varies and its times do not say so, or something holds or hides "
            f"the ball; the error of e holds as much ({flights.doubt:.2f})"
        )
