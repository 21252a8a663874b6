"""Times at which a ball was heard to bounce, as phyphox's "(In)elastic collision" writes them.

Between two bounces a ball rises and falls back to the same height: with the drag of the air the
time between gives the speeds at both ends, and two such times e of the bounce between them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

from analysis.arrays import Floats
from analysis.balls.document import Json, unseen
from analysis.balls.flight.known import STAY_S, Ball
from analysis.balls.tracks.table import BOUNCE, read_lines, split
from analysis.errors import InputError, ShotRefusedError, counted
from analysis.quantity import Quantity

HEARD_S = 1e-3
"""Standard error of the time at which a bounce is heard: the loudest sample, not the first."""
LEAST_BOUNCES = 3
FASTEST_M_PER_S = 1e3
STEP = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class BounceTimes:
    """When a ball bounced, s, increasing; shape (N,)."""

    times_s: Floats


def read_bounce_times(path: Path) -> BounceTimes:
    """Read the columns `Bounce 0 (s)`, `Bounce 1 (s)` and so on; one that is 0 was not heard.

    Raises
    ------
    InputError
        It is no text, has no such columns, several rows, or times that do not increase.
    """
    lines = [line for line in read_lines(path) if line.strip()]
    for separator in "\t;,":
        rows = split(lines, separator)
        columns = {
            int(name[1]): index
            for index, cell in enumerate(rows[0] if rows else [])
            if (name := BOUNCE.fullmatch(cell.strip())) is not None
        }
        if columns:
            break
    else:
        raise InputError(path, "has no columns Bounce 0 (s), Bounce 1 (s) and so on")
    if len(rows) != 2:
        raise InputError(path, f"has {len(rows) - 1} rows of bounces; one is read")
    try:
        times = np.array([float(rows[1][columns[k]]) for k in sorted(columns)])
    except (ValueError, IndexError) as error:
        raise InputError(path, f"has a bounce in line 2 that is no number: {error}") from error
    heard = times[times > 0.0]
    if not np.all(np.diff(heard) > 0):
        raise InputError(path, "has bounces that are not one after another")
    return BounceTimes(heard)


def bounce_document(bounces: BounceTimes, ball: Ball) -> Json:
    """Return e of each bounce that has another before and after it.

    Standard errors hold the times, the drag of the air, and how long contacts last.

    Raises
    ------
    ShotRefusedError
        Fewer than three bounces.
    """
    times = bounces.times_s
    if len(times) < LEAST_BOUNCES:
        raise ShotRefusedError(
            "frames",
            f"{counted(len(times), 'bounce')} heard; {LEAST_BOUNCES} are needed, as e is the speed "
            "after a bounce over that before it",
        )
    drag, drag_spread = ball.drag_per_m()
    known = np.array([*times, math.log(drag), 0.0])
    sigmas = np.array([*np.full(len(times), HEARD_S), drag_spread, STAY_S * ball.diameter_m / 0.02])
    found = _speeds(known, ball.gravity)
    slopes = np.stack(
        [
            (_speeds(known + step, ball.gravity) - _speeds(known - step, ball.gravity)) / (2 * STEP)
            for step in STEP * np.diag(sigmas)
        ],
        axis=-1,
    )
    impacts = [
        _impact(k, float(times[k]), found[k - 1], slopes[k - 1]) for k in range(1, len(times) - 1)
    ]
    alone = impacts[0] if len(impacts) == 1 else {}
    return {
        "status": "measured",
        **alone,
        "impacts": impacts,
        "drag_per_m": Quantity(drag, drag * drag_spread, "1/m").to_json(),
        "notes": list(_remarks(times, ball)),
    }


def _remarks(times: Floats, ball: Ball) -> Iterator[str]:
    yield (
        f"e is that of bounces 1 to {len(times) - 2} of 0 to {len(times) - 1}: the first has no "
        "flight before it whose ends are heard, the last none after it"
    )
    yield f"a bounce is taken to be heard within {1e3 * HEARD_S:g} ms"
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
        "e": Quantity(*e, "1").to_json(),
        "beta": None,
    }


def _speeds(known: Floats, gravity: float) -> Floats:
    """Return speeds before and after, and e, of the bounces between; shape (N - 2, 3)."""
    *times, log_drag, stay = known.tolist()
    drag = math.exp(log_drag)
    ends = [_ends(later - time - stay, drag, gravity) for time, later in pairwise(times)]
    return np.array([(before, after, after / before) for (_, before), (after, _) in pairwise(ends)])


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
