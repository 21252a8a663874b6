"""What a person should know of a film: sentences with frame and place."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from analysis.balls.films.film import FilmHead
from analysis.balls.flight.flights import LEAST_PLACES, Flights
from analysis.balls.measuring import MeasuredBall
from analysis.balls.seen.arcs import Arc, Chain

NEAR_RADII = 1.6
LARGE_CHI2 = 9.0


def remarks(measured: MeasuredBall) -> tuple[str, ...]:
    """Return the sentences of one film, none where nothing is out of the ordinary."""
    return tuple(_remarks(measured))


def _remarks(measured: MeasuredBall) -> Iterator[str]:
    head, chain = measured.head, measured.chain
    yield from head.notes
    yield from (_other(other) for other in measured.search.others)
    yield from _edges(measured)
    unexplained = [
        frame
        for frame in measured.search.unexplained
        if not chain.arcs[0].frames[0] <= frame <= chain.arcs[-1].frames[-1]
    ]
    if len(unexplained) >= LEAST_PLACES:
        yield (
            f"in frames {min(unexplained)} to {max(unexplained)} something like the ball is seen "
            "that does not fly freely: it rests, rolls or is held there; these frames do not count"
        )
    if measured.flights is None:
        arc = chain.arcs[0]
        yield (
            f"no bounce: the ball flies from frame {arc.frames[0]} {_at(arc, 0)} to frame "
            f"{arc.frames[-1]} {_at(arc, -1)} without a second flight that meets the first"
        )
        return
    yield from _of_flights(measured.flights, head)


def _other(other: Chain) -> str:
    arc = other.arcs[0]
    return (
        f"another ball of the same looks flies in frames {arc.frames[0]} to "
        f"{other.arcs[-1].frames[-1]}, first {_at(arc, 0)}; it is left out"
    )


def _at(arc: Arc, index: int) -> str:
    row, column = arc.places[index]
    return f"at ({row:.0f}, {column:.0f}) px"


def _edges(measured: MeasuredBall) -> Iterator[str]:
    """Say where the ball enters or leaves the picture, and where the film begins or ends."""
    head, chain = measured.head, measured.chain
    reach = NEAR_RADII * measured.looks.radius_px
    for arc, index, word in ((chain.arcs[0], 0, "enters"), (chain.arcs[-1], -1, "leaves")):
        row, column = arc.places[index]
        frame = int(arc.frames[index])
        inside = reach < row < head.height - reach and reach < column < head.width - reach
        at_the_film_s_end = frame in (0, head.frames - 1)
        if not inside and not at_the_film_s_end:
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


def _of_flights(flights: Flights, head: FilmHead) -> Iterator[str]:
    fall, fall_sigma = flights.scale_of_fall
    size, size_sigma = flights.scale_of_diameter
    if flights.contradiction:
        ratio = fall / size
        yield (
            f"the diameter contradicts gravity: by its fall the ball is {ratio:.3f} ± "
            f"{math.hypot(fall_sigma, size_sigma):.3f} of the stated diameter times as large; "
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
    row_rms = float(np.std(flights.residuals[flights.used, 0]))
    if row_rms > 1.0:
        yield (
            f"places scatter by {row_rms:.1f} px about free flights: check that times and frame "
            "rate are those of the film, and that nothing hides the ball"
        )
    left_out = [int(f) for f in flights.observed.frames[~flights.used]]
    if left_out:
        yield (
            "frames that do not count (exposed during a contact, or off the flights): "
            + ", ".join(map(str, left_out))
        )
