"""What a person should know of a film: sentences with frame and place."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.balls.beside import edges, hands, one_more, outside, place_of
from analysis.balls.doubts import doubts
from analysis.balls.films.film import FilmHead
from analysis.balls.flight.flights import LEAST_PLACES, MOST_LEFT_OUT, Flights
from analysis.balls.gaps import period_of
from analysis.balls.measuring import MeasuredBall
from analysis.balls.seen.arcs import Arc, Chain
from analysis.errors import counted

CONTACT_FRAMES = 0.6
"""Frames beside a contact, and half the exposure, in which places may show part of it."""
FEW_GAPS = 1
"""Places at which a film lacks frames whose rate holds."""
SHOWN = 12
"""Frames that a sentence lists."""

UNSHOWN = (
    "whether the camera moved cannot be seen: too little that stands still has edges, or a codec "
    "carries its noise along; on a stand that is right, but if the camera was held by hand, places "
    "and e may be further off than their errors say"
)
"""Of a film that a codec has been at, as those that are held by hand."""


def remarks(measured: MeasuredBall) -> tuple[str, ...]:
    """Return the sentences of one film, none where nothing is out of the ordinary."""
    return tuple(_remarks(measured))


def _remarks(measured: MeasuredBall) -> Iterator[str]:
    head, chain = measured.head, measured.chain
    yield from head.notes
    yield from (_other(*other) for other in measured.search.others)
    if head.compressed and not measured.search.shake_shown:
        yield UNSHOWN
    yield from _missing(measured)
    yield from edges(measured)
    yield from _repeated(measured)
    yield from outside(measured)
    if len(measured.placed.frames):
        yield from hands(measured)
    if measured.flights is None:
        yield _no_bounce(chain.arcs[0], head.frames - 1)
        return
    walls = wall_remark([flights for _, flights in measured.surfaces])
    yield from [] if walls is None else [walls]
    yield from one_more(measured, measured.flights)
    for one, flights in measured.surfaces:
        yield from _of_flights(flights, head)
        yield from _do_not_count(one, flights)
        yield from doubts(one, flights, alone=not measured.others)


def wall_remark(surfaces: Sequence[Flights]) -> str | None:
    """Say which bounces are off a wall; None: none is. The first surface is that of the poses."""
    order = sorted((float(t), one.off_a_wall) for one in surfaces for t in one.contacts[:, 0])
    walls = [k for k, (_, off_a_wall) in enumerate(order, start=1) if off_a_wall]
    if not walls:
        return None
    said = f"bounce{'s' * (len(walls) > 1)} {', '.join(map(str, walls))}"
    about = "that wall" if surfaces[0].off_a_wall else "one stretch of the plate, floor or table"
    return (
        f"{said} of {len(order)}: off a wall, taken to be plumb within 0.01 rad; places in rig "
        f"axes (poses, --out) are those about {about}, with {surfaces[0].bounces} of the bounces"
    )


def _no_bounce(arc: Arc, last: int) -> str:
    """Say that a flight is seen alone, and why."""
    left = last - int(arc.frames[-1])
    said = (
        f"no bounce: the ball flies from frame {arc.frames[0]} {place_of(arc, 0)} to frame "
        f"{arc.frames[-1]} {place_of(arc, -1)} without a second flight that meets the first"
    )
    if left <= LEAST_PLACES:
        return (
            f"{said}; the film ends {counted(left, 'frame')} later, at frame {last}, and a flight "
            f"after a bounce needs {LEAST_PLACES} of its own"
        )
    return (
        f"{said}; if it bounces there, frames are missing, or the film's rate varies without times "
        "of its own"
    )


def _other(other: Chain, is_round: bool) -> str:
    arc = other.arcs[0]
    what = "another ball flies" if is_round else "something else moves"
    return (
        f"{what} in frames {arc.frames[0]} to "
        f"{other.arcs[-1].frames[-1]}, first {place_of(arc, 0)}; it is left out"
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


def _listed(frames: list[int]) -> str:
    """Return numbers with commas, the first of many."""
    more = f" and {len(frames) - SHOWN} more" if len(frames) > SHOWN else ""
    return ", ".join(map(str, frames[:SHOWN])) + more


def _do_not_count(measured: MeasuredBall, flights: Flights) -> Iterator[str]:
    """Name the frames of the flights that do not count, by reason."""
    near = 0.5 * measured.exposure_s + CONTACT_FRAMES * period_of(measured.times_s)
    yield from do_not_count(flights, flights.observed.frames, near)


def do_not_count(flights: Flights, numbers: NDArray[Any], near_s: float) -> Iterator[str]:
    """Name the frames of some flights that do not count, by reason.

    Parameters
    ----------
    numbers
        Of the frames of the places, shape (N,).
    near_s
        From a contact to places that may show part of it.
    """
    times = flights.observed.times_s + flights.row_delay(flights.observed.places)
    contacts = np.append(flights.contacts[:, 0], flights.next_contact_s)
    apart = np.abs(times[:, None] - contacts).min(axis=1)
    touching = (apart < near_s) | (times > contacts[-1])
    for which, why in (
        (~flights.used & touching, "exposed during a contact, or next to one"),
        (~flights.used & ~touching, "off the flights"),
    ):
        if which.any():
            listed = ", ".join(str(int(number)) for number in numbers[which])
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
