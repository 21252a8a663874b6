"""What a tracker's table shows of a ball, as other programs read it."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from analysis.balls.document import Json, flight_impact, flights_document, with_others
from analysis.balls.doubts import leaning, pushed_aside
from analysis.balls.gaps import period_of
from analysis.balls.remarks import CONTACT_FRAMES, do_not_count, wall_remark
from analysis.balls.tracks.measuring import MeasuredTrack
from analysis.errors import counted
from analysis.quantity import Quantity

AXES = "xyz"


def track_document(measured: MeasuredTrack) -> Json:
    """Return the bounces, with the table's own frame numbers, scale and remarks."""
    flights = measured.flights
    found = [measured.coefficient(bounce) for bounce in range(flights.bounces)]
    document = flights_document(flights, found, flights.scatter, measured.times_s)
    beside = [
        [flight_impact(one, k, one.coefficient(k), measured.times_s) for k in range(one.bounces)]
        for one in measured.beside
    ]
    document["impacts"] = with_others(document["impacts"], beside)
    for each in (document, *document["impacts"]):
        for key in ("frames_before", "frames_after"):
            if key in each:
                each[key] = [int(number) for number in measured.numbers[each[key]]]
        if "frame" in each:
            order = np.arange(len(measured.numbers))
            each["frame"] = float(np.interp(each["frame"], order, measured.numbers))
    document["frame_rate_hz"] = 1.0 / period_of(measured.times_s)
    fall, sigma = flights.scale_of_fall
    by_fall = fall / measured.px_per_unit
    document["scale_units_per_m"] = {
        "from_gravity": Quantity(by_fall, by_fall * sigma, "1/m").to_json()
        if math.isfinite(sigma)
        else None,
        "stated": None if measured.metres is None else 1.0 / measured.metres,
        "agree": not flights.contradiction and (measured.metres is None or measured.unit_believed),
    }
    document["notes"] = list(_remarks(measured))
    return document


def _remarks(measured: MeasuredTrack) -> Iterator[str]:
    """Say what a person should know of a table."""
    flights = measured.flights
    yield from measured.notes
    way = "+" if measured.fall.size > 0 else "-"
    scale, sigma = flights.scale_of_fall[0] / measured.px_per_unit, flights.scale_of_fall[1]
    if measured.metres is None:
        said = f"{scale:.4g} ± {scale * sigma:.2g} units a metre"
        yield (
            f"things fall along {way}{AXES[measured.fall.axis]}; the table states no unit, and the "
            f"scale is that of gravity: {said}"
        )
    elif flights.contradiction or not measured.unit_believed:
        ratio = 1.0 / (scale * measured.metres)
        yield (
            f"the table's unit contradicts gravity: by the fall it is {ratio:.3f} ± "
            f"{ratio * sigma:.3f} of what is stated; speeds are scaled by gravity, e does not "
            "depend on it; check the length that the tracker was calibrated with, and the times"
        )
    beside, apart = measured.others
    if beside:
        fly = "flies and bounces" if beside == 1 else "fly and bounce"
        yield f"{counted(beside, 'other thing')} in the table {fly} too; left out"
    if apart:
        yield (
            f"{counted(apart, 'flight')} of the table meet{'s' * (apart == 1)} none of the flights "
            "about these bounces; left out: places are missing there, or another ball flies"
        )
    walls = wall_remark([flights, *measured.beside])
    yield from [] if walls is None else [walls]
    near = CONTACT_FRAMES * period_of(measured.times_s)
    yield from do_not_count(flights, measured.numbers[flights.observed.frames], near)
    for each in (flights, *measured.beside):
        yield from leaning(each)
        yield from pushed_aside(each)
    if flights.doubt:
        yield (
            f"{int((~flights.used).sum())} of {len(flights.used)} places lie off free flights; "
            f"the error of e holds as much ({flights.doubt:.2g})"
        )
