"""From a tracker's table to the flights and bounces of a ball.

A table has no pictures: what a place may be off by is what places scatter about the flights, and
its scale is that by which things fall, compared with the table's unit where it states one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.flight.fit import fit_flights
from analysis.balls.flight.flights import Flights, Observed
from analysis.balls.flight.known import Ball, Known, View
from analysis.balls.flight.lost import unsure_e
from analysis.balls.hands import let_go
from analysis.balls.seen.arcs import Chain, Sightings, chains, find_arcs
from analysis.balls.seen.joining import joined
from analysis.balls.surfaces import Part, parts
from analysis.balls.tracks.clock import Clock, clock_of
from analysis.balls.tracks.fall import TableFall, table_fall
from analysis.balls.tracks.table import TrackTable
from analysis.errors import ShotRefusedError, counted

RADIUS_PX = 20.0
"""Of the ball in the picture that a table is turned into: the search has tolerances in pixels."""
RADII_OF_SCATTER, WIDEST_PX = 20.0, 160.0
"""Least radius with which is searched, in the scatter of places: tolerances are shares of it. And
the largest: where places scatter farther, the fall that was found is not the ball's."""
SCALE_SIGMA, UNIT_SIGMA = 2.0, 0.03
"""Of a scale's logarithm that nobody states, and of one that follows from a table's unit: a length
was held beside the flight, nearer to the camera or farther."""
EXPOSED = 0.5
"""Of the time between frames, where no exposure is stated: a place is the middle of a smear."""
LEAST_SIGMA_PX = 1e-4
"""Of places that follow one another without any scatter."""
ANY_READOUT = 0.4, 0.4
"""Middle and spread of the time in which a frame is read, of that between frames: of a telephone,
or of a camera or a computation that has all of it at once."""
TELLING = 20
"""Places of a thing that tell whether it falls."""
LEAST_ALIKE = 0.6
"""Of a fall, and of a scale: what two of one ball have in common at least."""
LEAST_RATE_HZ = 15.0
"""Of most bounces that fill a picture: a ball is in the air for a third of a second between."""
MARGIN_RADII = 2.0
"""About all places, of the picture that they are in."""


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredTrack:
    """A ball of a table, and how the table was turned into a picture.

    Attributes
    ----------
    flights
        In the picture's pixels, down the rows.
    times_s
        Of the frames in which something is seen.
    numbers
        The table's number of each frame.
    fall
        How things fall in the table.
    px_per_unit
        Pixels of one of the table's units.
    metres
        What the table says that a unit is; None: nothing.
    unit_believed
        Whether that unit is near enough to gravity's to be taken.
    others
        How many other things bounce beside the ball, and how many flights meet none of its own.
    size
        Rows and columns of the picture.
    unsure_e
        By how much e of each bounce changes with a time that seems to be missing, shape (B,).
    notes
        Of the table.
    beside
        Flights about bounces off other surfaces, such as walls.
    """

    flights: Flights
    times_s: Floats
    numbers: Floats
    fall: TableFall
    px_per_unit: float
    metres: float | None
    unit_believed: bool
    others: tuple[int, int]
    size: tuple[int, int]
    unsure_e: Floats
    notes: tuple[str, ...]
    beside: tuple[Flights, ...] = ()

    def coefficient(self, bounce: int) -> tuple[float, float]:
        """Return e of a bounce and its standard error."""
        e, sigma = self.flights.coefficient(bounce)
        return e, math.hypot(sigma, float(self.unsure_e[bounce]))


def measure_track(
    table: TrackTable, ball: Ball, rate_hz: float | None, exposure_s: float | None
) -> MeasuredTrack:
    """Find the flights of a ball among the places of a table, and measure its bounces.

    Parameters
    ----------
    rate_hz
        Frames a second of the camera; None: by the table's times.
    exposure_s
        None: half the time between frames.

    Raises
    ------
    ShotRefusedError
        No times, nothing that falls, or no bounce with four places on both sides.
    """
    clock = clock_of(table, rate_hz)
    try:
        return _measured(table, clock, ball, exposure_s)
    except ShotRefusedError as refusal:
        rate = 1.0 / clock.period_s
        if refusal.step != "flight" or rate >= LEAST_RATE_HZ:
            raise
        raise ShotRefusedError(
            refusal.step,
            f"{refusal.reason}; {rate:.3g} frames/s are few: four places are needed between two "
            f"bounces, which takes some {LEAST_RATE_HZ:g} frames/s; check the times and their unit",
        ) from refusal


def _measured(
    table: TrackTable, clock: Clock, ball: Ball, exposure_s: float | None
) -> MeasuredTrack:
    fall, falling = _fall(table, clock)
    by_fall = abs(fall.size) / ball.gravity
    px = 2.0 * RADIUS_PX / ball.diameter_m / by_fall
    wide = RADII_OF_SCATTER * fall.scatter * px
    radius = wide if RADIUS_PX < wide < WIDEST_PX else RADIUS_PX
    margin = MARGIN_RADII * radius
    seen = _sightings(clock, _picture(table.places, fall, px, margin), falling, margin)
    down = np.array([abs(fall.size) * px, 0.0])
    arcs = joined(find_arcs(seen, radius, down), radius, down, seen.shape)
    linked = chains(arcs, radius, down)
    if not linked or not len(linked[0].times_s):
        raise ShotRefusedError("flight", _no_bounce(linked))
    view = View(
        *seen.shape,
        clock.period_s,
        EXPOSED * clock.period_s if exposure_s is None else exposure_s,
        readout="rows",
        readout_share=ANY_READOUT,
    )
    told = None if table.metres is None else px / table.metres
    known = _known(ball, view, told if _believed(table.metres, by_fall) else None)
    fitted = [
        _fitted(part, seen.times_s, known, down) for part in parts(linked[0], down, ball.plate_lean)
    ]
    found = [flights for flights in fitted if flights is not None]
    if not found:
        raise ShotRefusedError("flight", _no_bounce(linked))
    flights, *beside = found
    return MeasuredTrack(
        flights=flights,
        times_s=seen.times_s,
        numbers=clock.numbers,
        fall=fall,
        px_per_unit=px,
        metres=table.metres,
        unit_believed=_believed(table.metres, by_fall),
        others=_others(linked),
        size=seen.shape,
        unsure_e=np.zeros(flights.bounces) if flights.off_a_wall else unsure_e(flights),
        beside=tuple(beside),
        notes=(*table.notes, *clock.notes),
    )


def _fall(table: TrackTable, clock: Clock) -> tuple[TableFall, NDArray[np.bool_]]:
    """Return the fall of the thing that is seen most often and falls, and what may be of a ball.

    What is seen often and does not fall so is another thing. A few places do not tell: trackers
    give a ball another number at a bounce.
    """
    names, counts = np.unique(table.things, return_counts=True)
    fall: TableFall | None = None
    refused: ShotRefusedError | None = None
    kept = np.ones(len(table.things), dtype=bool)
    for name in names[np.argsort(-counts, kind="stable")]:
        of_it = table.things == name
        own = np.flatnonzero(of_it)
        if fall is not None and len(own) < TELLING:
            continue
        own = own[np.argsort(clock.index[own], kind="stable")]
        try:
            found = table_fall(clock.times_s[clock.index[own]], table.places[own])
        except ShotRefusedError as error:
            refused = refused or error
            kept &= ~of_it | (len(own) < TELLING)
            continue
        fall = fall or found
        alike = found.axis == fall.axis and LEAST_ALIKE < found.size / fall.size < 1 / LEAST_ALIKE
        kept &= ~of_it | alike
    if fall is None:
        raise refused or ShotRefusedError("flight", "the table holds no places")
    return fall, kept


def _believed(metres: float | None, by_fall: float) -> bool:
    """Return whether a table's unit is near enough to gravity's to be a scale at all."""
    return metres is not None and LEAST_ALIKE < metres * by_fall < 1.0 / LEAST_ALIKE


def _others(linked: list[Chain]) -> tuple[int, int]:
    """Return how many other things bounce beside the ball, and flights that meet none of its."""
    own = {int(frame) for arc in linked[0].arcs for frame in arc.frames}
    beside = apart = 0
    for one in linked[1:]:
        theirs = [int(frame) for arc in one.arcs for frame in arc.frames]
        if len(theirs) < TELLING:
            continue
        shared = sum(frame in own for frame in theirs)
        beside += shared > len(theirs) // 2 and len(one.times_s) > 0
        apart += shared <= len(theirs) // 2
    return beside, apart


def _picture(places: Floats, fall: TableFall, px: float, margin: float) -> Floats:
    """Return places as rows and columns of a picture in which things fall down, shape (N, 2)."""
    beside = [axis for axis in range(places.shape[1]) if axis != fall.axis]
    across = max(beside, key=lambda axis: float(np.ptp(places[:, axis])))
    both = np.stack([math.copysign(px, fall.size) * places[:, fall.axis], px * places[:, across]])
    return np.asarray((both - both.min(axis=1, keepdims=True)).T + margin)


def _sightings(
    clock: Clock, places: Floats, falling: NDArray[np.bool_], margin: float
) -> Sightings:
    own: list[list[list[float]]] = [[] for _ in clock.times_s]
    for index, (row, column) in zip(clock.index[falling].tolist(), places[falling], strict=True):
        own[index].append([row, column, 1.0])
    height, width = np.ceil(places.max(axis=0) + margin).astype(int).tolist()
    found = [np.array(each).reshape(-1, 3) for each in own]
    return Sightings(clock.times_s, found, (height, width))


def _fitted(part: Part, times: Floats, known: Known, fall: Floats) -> Flights | None:
    """Return the flights about the bounces off one surface; None: too few places beside them."""
    return fit_flights(_observed(part.chain, times), part.start(fall), known)


def _observed(chain: Chain, times: Floats) -> Observed:
    """Return places of the flights; of a ball that is held before or after, those are none."""
    frames = np.concatenate([arc.frames for arc in chain.arcs])
    places = np.concatenate([arc.places for arc in chain.arcs])
    order = np.argsort(frames, kind="stable")
    frames, places = frames[order], places[order]
    sigma = max(LEAST_SIGMA_PX, float(np.median([_scatter(arc.places) for arc in chain.arcs])))
    kept = let_go(frames, places[:, 0], (chain, times), RADIUS_PX)
    sigmas = np.full((len(frames), 2), sigma)
    return Observed(frames, times[frames], places, sigmas).of(kept)


def _scatter(places: Floats) -> float:
    """Return the scatter of places that a parabola leaves, by their third differences."""
    if len(places) < 5:
        return 0.0
    third = np.diff(places, n=3, axis=0)
    return float(1.4826 * np.median(np.abs(third)) / math.sqrt(20.0))


def _known(ball: Ball, view: View, px_per_m: float | None) -> Known:
    """Return what is known beforehand: the scale by the table's unit, or hardly any."""
    if px_per_m is None:
        return Known(replace(ball, diameter_sigma=SCALE_SIGMA), view, RADIUS_PX)
    own = replace(ball, diameter_sigma=UNIT_SIGMA)
    return Known(own, view, 0.5 * px_per_m * ball.diameter_m)


def _no_bounce(linked: list[Chain]) -> str:
    if not linked:
        return "no four places of the table that follow one another fall freely"
    frames = sum(len(arc.frames) for arc in linked[0].arcs)
    return (
        f"no bounce: {counted(frames, 'place')} fall freely without a second flight of four "
        "places that meets the first"
    )
