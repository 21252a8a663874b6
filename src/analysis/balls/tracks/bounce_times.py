"""Times at which a ball was heard to bounce, as phyphox's "(In)elastic collision" writes them.

Between two bounces a ball rises and falls back to the same height: with the drag of the air the
time between gives the speeds at both ends, and two such times e of the bounce between them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

from analysis.arrays import Floats
from analysis.balls.document import Json, unseen
from analysis.balls.flight.kinds import contact_time
from analysis.balls.flight.known import Ball
from analysis.balls.tracks.cells import NONE, read_lines, split
from analysis.balls.tracks.columns import BOUNCE, SECONDS
from analysis.errors import InputError, ShotRefusedError, counted
from analysis.quantity import Quantity

HEARD_S = 1e-3
"""Standard error of the time at which a bounce is heard: the loudest sample, not the first."""
LEAST_BOUNCES, LONGEST_S, MOST_BOUNCES = 3, 6.0, 1000
"""One after another that tell an e, and the longest time between two: of a fall from 40 m. And by
how much their numbers may differ."""
FASTEST_M_PER_S = 1e3
STEP = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class BounceTimes:
    """When each bounce was heard.

    Attributes
    ----------
    times_s
        Increasing; shape (N,). Nan: it was not heard.
    first
        The table's number of the first of them.
    notes
        How the table was read.
    """

    times_s: Floats
    first: int = 0
    notes: tuple[str, ...] = ()


def read_bounce_times(path: Path) -> BounceTimes:
    """Read the columns `Bounce 0 (s)`, `Bounce 1 (s)` and so on.

    One whose number is missing, or that is empty or 0, was not heard. A first one at exactly 0,
    soon before the second, is where the clock was started.

    Raises
    ------
    InputError
        It is no text, has no such columns, several rows, or times that do not increase.
    """
    lines = [line for line in read_lines(path) if line.strip()]
    for separator in "\t;,":
        rows = split(lines, separator)
        columns = {
            int(name[1]): (index, (name[2] or "s").lower())
            for index, cell in enumerate(rows[0] if rows else [])
            if (name := BOUNCE.fullmatch(cell.strip())) is not None
        }
        if columns:
            break
    else:
        raise InputError(path, "has no columns Bounce 0 (s), Bounce 1 (s) and so on")
    if len(rows) != 2:
        raise InputError(path, f"has {len(rows) - 1} rows of bounces; one is read")
    first, last = min(columns), max(columns)
    if last - first >= MOST_BOUNCES:
        raise InputError(path, f"counts its bounces from {first} to {last}; {MOST_BOUNCES} at most")
    times = np.full(last - first + 1, math.nan)
    for number, column in columns.items():
        times[number - first] = _heard(path, rows[1], *column)
    started = times[0] == 0.0 and len(times) > 1 and bool(0.0 < times[1] < LONGEST_S)
    times[1:][~(times[1:] > 0.0)] = math.nan
    times[0] = times[0] if started or times[0] > 0.0 else math.nan
    if not np.all(np.diff(times[np.isfinite(times)]) > 0):
        raise InputError(path, "has bounces that are not one after another")
    known = np.flatnonzero(np.isfinite(times)).max(initial=-1)
    said = (
        f"bounce {first} is at exactly 0 s, and taken for the clock's start; leave its cell empty "
        "if it was not heard"
    )
    return BounceTimes(times[: known + 1], first, (said,) if started else ())


def _heard(path: Path, row: Sequence[str], index: int, unit: str) -> float:
    """Return one time, s; nan where the cell is empty."""
    if unit not in SECONDS:
        raise InputError(path, f"has times in “{unit}”, which is none of {', '.join(SECONDS)}")
    cell = row[index].strip() if index < len(row) else ""
    if cell.lower() in NONE:
        return math.nan
    try:
        return SECONDS[unit] * float(cell)
    except ValueError as error:
        raise InputError(path, f"has “{cell}” in line 2, which is no number") from error


def bounce_document(bounces: BounceTimes, ball: Ball) -> Json:
    """Return e of each bounce that has another before and after it.

    Standard errors hold the times, the drag of the air, and how long contacts last.

    Raises
    ------
    ShotRefusedError
        Fewer than three bounces.
    """
    times = bounces.times_s
    between = np.isfinite(times[:-2] + times[1:-1] + times[2:]) if len(times) > 2 else np.zeros(0)
    if not between.any():
        heard = counted(int(np.isfinite(times).sum()), "bounce")
        raise ShotRefusedError(
            "frames",
            f"{heard} heard, and no {LEAST_BOUNCES} one after another; e is the speed after a "
            "bounce over that before it",
        )
    lasts = np.diff(times)
    if np.nanmax(lasts) > LONGEST_S:
        k = int(np.nanargmax(lasts))
        own = bounces.first + k
        raise ShotRefusedError(
            "frames",
            f"{lasts[k]:.3g} s between bounces {own} and {own + 1}; no ball flies for more than "
            f"{LONGEST_S:g} s: check the unit of the times, and that no bounce between was missed",
        )
    drag, drag_spread = ball.drag_per_m()
    drag_sigma = _of_a_factor(drag_spread)
    stay, stay_sigma = contact_time(ball)
    impacts = []
    for k in (np.flatnonzero(between) + 1).tolist():
        known = np.array([*times[k - 1 : k + 2], math.log(drag), stay])
        sigmas = np.array([HEARD_S, HEARD_S, HEARD_S, drag_sigma, stay_sigma])
        found = _speeds(known, ball.gravity)
        slopes = np.stack(
            [
                (_speeds(known + step, ball.gravity) - _speeds(known - step, ball.gravity))
                / (2 * STEP)
                for step in STEP * np.diag(sigmas)
            ],
            axis=-1,
        )
        impacts.append(_impact(bounces.first + k, float(times[k]), found, slopes))
    return {
        "status": "measured",
        **(impacts[0] if len(impacts) == 1 else {}),
        "impacts": impacts,
        "drag_per_m": Quantity(drag, drag * drag_sigma, "1/m").to_json(),
        "notes": [*bounces.notes, *_remarks(bounces, impacts, ball)],
    }


def _of_a_factor(spread: float) -> float:
    """Return the root mean square by which a number is off whose logarithm is known so well.

    A ball of unknown mass may be far lighter, and slowed far more, than the logarithm's own
    spread says: its factor has a longer side.
    """
    return math.sqrt(math.exp(2.0 * spread**2) - 2.0 * math.exp(0.5 * spread**2) + 1.0)


def _remarks(bounces: BounceTimes, impacts: Sequence[Json], ball: Ball) -> Iterator[str]:
    first, last = bounces.first, bounces.first + len(bounces.times_s) - 1
    own = ", ".join(str(impact["bounce"]) for impact in impacts)
    yield (
        f"e is that of bounce{'s' * (len(impacts) > 1)} {own} of {first} to {last}: the "
        "first has no flight before it whose ends are heard, the last none after it"
    )
    if missed := [str(first + k) for k in np.flatnonzero(~np.isfinite(bounces.times_s))]:
        yield f"not heard: {', '.join(missed)}; bounces beside it have no e"
    yield f"a bounce is taken to be heard within {1e3 * HEARD_S:g} ms"
    for impact in impacts:
        if impact["e"]["value"] > 1.0:
            yield (
                f"e of bounce {impact['bounce']} is {impact['e']['value']:.2f}, and no ball leaves "
                "a floor faster than it came: a bounce was missed, or something else was heard; "
                "its error holds as much, and e of its neighbours is in doubt"
            )
    if ball.density is None:
        yield "the ball's mass is not stated: its drag, and e, are surer with --ball-mass-g"


def _impact(number: int, time_s: float, found: Floats, slopes: Floats) -> Json:
    """Return one bounce; slopes are changes by one standard error of each known number."""
    before, after, e = (
        (float(value), float(np.linalg.norm(slope)))
        for value, slope in zip(found, slopes, strict=True)
    )
    return {
        "bounce": number,
        "contact_time_s": time_s,
        "contact_time_sigma_s": HEARD_S,
        "contact_duration": None,
        "v_n": Quantity(-before[0], before[1], "m/s").to_json(),
        "v_n_after": Quantity(*after, "m/s").to_json(),
        **{key: unseen("m/s") for key in ("v_t", "v_t_after", "v_s", "v_s_after")},
        # What is beyond 1 is error, as of bounces that are seen.
        "e": Quantity(e[0], math.hypot(e[1], max(0.0, e[0] - 1.0)), "1").to_json(),
        "beta": None,
    }


def _speeds(known: Floats, gravity: float) -> Floats:
    """Return speeds before and after a bounce, and e, shape (3,).

    From the times of three bounces, the drag's logarithm, and how long contacts last.
    """
    first, bounce, last, log_drag, stay = known.tolist()
    drag = math.exp(log_drag)
    _, before = _ends(bounce - first - stay, drag, gravity)
    after, _ = _ends(last - bounce - stay, drag, gravity)
    return np.array([before, after, after / before])


def _ends(lasts_s: float, drag: float, gravity: float) -> tuple[float, float]:
    """Return the speeds with which a ball leaves the floor and comes back after so long a time.

    Upwards and downwards with a drag of k v^2 (textbook): heights log(1 + k u^2 / g) / (2 k).
    """

    def come_back(left: float) -> tuple[float, float]:
        root = math.sqrt(drag * gravity)
        turn = math.log1p(drag * left**2 / gravity)
        rising = math.atan(left * math.sqrt(drag / gravity)) / root
        falling = math.acosh(math.exp(0.5 * turn)) / root
        return rising + falling, math.sqrt(gravity / drag * -math.expm1(-turn))

    left = brentq(lambda speed: come_back(speed)[0] - lasts_s, 0.0, FASTEST_M_PER_S, xtol=1e-12)
    return float(left), come_back(float(left))[1]
