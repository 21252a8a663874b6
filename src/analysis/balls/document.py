"""A film of one ball as other programs read it (commands.md): impacts in order of time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from analysis.arrays import Floats
from analysis.balls.flight import path
from analysis.balls.flight.flights import Flights
from analysis.balls.gaps import frame_at, period_of
from analysis.balls.measuring import MeasuredBall, coefficient
from analysis.balls.seen.placing import Placed
from analysis.motion.drift import WORST_LENGTH, line_variances
from analysis.quantity import Quantity

Json = dict[str, Any]
Coefficient = tuple[float, float]
"""e of a bounce and its standard error."""

UNTOLD = 0.5
"""Error of the logarithm of a scale that nobody states."""
UNBENDING = 8
"""Steps in which a lens's bending of a few per cent is undone to rounding."""
LEAST_E = 3e-4
"""Error of e whose bent flights are the least that single films leave: radius, outlines and light
bend flights in ways that e does not feel, and the drag of the air does."""


def _poses(flights: Flights, found: Sequence[Coefficient], scatter: Floats) -> Json:
    """Return times and places of a ball in rig axes, and what all of them share.

    What the camera does to them is taken out. X is along gravity and Y across the picture, both
    from the first contact. Where along the line of sight a ball is, one view does not tell. The
    errors of single places are those beside one another; `slow_m` is what the places of one
    flight share. `scale_sigma` is what the ball's diameter leaves of the scale, or gravity where
    the two contradict each other or nothing else tells it; `normal` is that of the plate.
    """
    observed, used = flights.observed, flights.used
    scale = flights.scale_px_per_m
    times = observed.times_s + flights.row_delay(observed.places)
    places = _upright(flights, _in_plane(flights, times)) / scale
    distance = flights.at(times, flights.arcs)[:, 2]
    sigmas = scatter * distance[:, None] / scale
    lean = flights.lean
    told = not flights.contradiction and flights.scale_of_diameter[1] < UNTOLD
    by_size = flights.scale_of_diameter if told else flights.scale_of_fall
    return {
        "frame": observed.frames[used].tolist(),
        "t_s": times[used].tolist(),
        "x_m": places[used, 0].tolist(),
        "y_m": places[used, 1].tolist(),
        "sigma_x_m": sigmas[used, 0].tolist(),
        "sigma_y_m": sigmas[used, 1].tolist(),
        "normal": [math.cos(lean), -math.sin(lean), 0.0],
        "scale_px_per_m": scale,
        "scale_sigma": by_size[1],
        "slow_m": float(
            np.median([_slow(flights, k, sigma) for k, (_, sigma) in enumerate(found)])
        ),
    }


def _slow(flights: Flights, bounce: int, sigma_e: float) -> float:
    """Return the error of places that leaves e of a bounce as uncertain as the film does, m.

    Rolling shutter, lens, line of sight and light bend flights; no scatter of places shows it. A
    fit of poses takes such errors of a ball without spin to make rates worst.
    """
    sigma = math.hypot(sigma_e, LEAST_E)
    contact, arcs = flights.contacts[bounce], flights.arcs[flights.used]
    times = flights.observed.times_s[flights.used]
    before, after = (float(np.ptp(times[arcs == k])) for k in (bounce, bounce + 1))
    if min(before, after) <= 0.0:
        return 0.0
    e = contact[3] / contact[1]
    _, slope = line_variances(np.array(WORST_LENGTH))
    each = math.sqrt(float(slope)) * math.hypot(1.0 / after, e / before)
    return float(sigma * contact[1] / each / flights.scale_px_per_m)


def _in_plane(flights: Flights, times: Floats) -> Floats:
    """Return places in the plane of the flight as `path` has them, down and across, px, (N, 2)."""
    values = flights.values
    found = flights.at(times, flights.arcs)
    middle, half = values[path.PRINCIPAL], float(values[path.HALF])
    bent = flights.observed.places - middle
    straight = bent
    for _ in range(UNBENDING):
        square = (straight**2).sum(axis=1, keepdims=True)
        straight = bent / (1.0 + values[path.BARREL] * square / half**2)
    straight = straight * found[:, 2:]
    straight[:, 0] -= values[path.PLATE] - values[path.MIDDLE_ROW]
    # The rest of the distance has drifted away, and is seen higher by a camera that looks down.
    rise = path.rise(values)
    straight[:, 0] += rise * (found[:, 2] - 1.0)
    straight[:, 0] /= 1.0 + rise * values[path.PERSPECTIVE]
    return np.asarray(straight)


def _upright(flights: Flights, places: Floats) -> Floats:
    """Return places turned so that the first axis is along gravity."""
    roll = float(flights.values[path.ROLL])
    down, across = places.T
    return np.stack(
        [
            down * math.cos(roll) + across * math.sin(roll),
            across * math.cos(roll) - down * math.sin(roll),
        ],
        axis=1,
    )


TIME, TOWARDS, BESIDE, AWAY, BESIDE_AFTER, _ = range(6)
"""Of a contact, as `path.places` gives it."""


def ball_document(measured: MeasuredBall, notes: tuple[str, ...]) -> Json:
    """Return what was measured; a film with one impact has that one's keys at the top too."""
    flights, times = measured.flights, measured.times_s
    if flights is None:
        document: Json = {"status": "measured", "impacts": []}
    else:
        found = [coefficient(measured, bounce) for bounce in range(flights.bounces)]
        document = flights_document(flights, found, measured.scatter, times) | _camera(flights)
        document["impacts"] = with_others(document["impacts"], _at_others(measured))
    document["frame_rate_hz"] = 1.0 / period_of(times)
    looks, placed = measured.looks, measured.placed
    document["ball"] = {
        "diameter_px": Quantity(2 * looks.radius_px, 2 * looks.radius_sigma_px, "px").to_json()
    }
    document["exposure_s"] = measured.exposure_s
    document["exposure_sigma_s"] = measured.exposure_found
    document["positions"] = positions(placed, times) | {
        "scatter_row_px": measured.scatter[:, 0].tolist(),
        "scatter_column_px": measured.scatter[:, 1].tolist(),
    }
    document["notes"] = list(notes)
    return document


def _at_others(measured: MeasuredBall) -> list[list[Json]]:
    """Return the bounces off each of the other surfaces."""
    return [
        [flight_impact(flights, k, coefficient(one, k), one.times_s) for k in range(one.bounces)]
        for one, flights in measured.surfaces[1:]
    ]


def with_others(impacts: list[Json], others: Sequence[list[Json]]) -> list[Json]:
    """Return the bounces off all surfaces in order of time, each with its `surface`.

    Surface 0 is that of `poses`; others are walls, which are of another material as a rule. Where
    there is one alone, none is named.
    """
    if not others:
        return impacts
    every = [
        {**impact, "surface": number}
        for number, own in enumerate([impacts, *others])
        for impact in own
    ]
    return sorted(every, key=lambda impact: float(impact["contact_time_s"]))


def flights_document(
    flights: Flights, found: Sequence[Coefficient], scatter: Floats, times_s: Floats
) -> Json:
    """Return the bounces of some flights, and their places in rig axes.

    Parameters
    ----------
    found
        e of each bounce and its standard error.
    scatter
        Standard errors of places beside one another, px, shape (N, 2).
    times_s
        Of all frames.
    """
    impacts = [flight_impact(flights, k, each, times_s) for k, each in enumerate(found)]
    alone = impacts[0] if len(impacts) == 1 else {}
    drag = flights.values[path.DRAG] * flights.scale_px_per_m
    return {
        "status": "measured",
        **alone,
        "impacts": impacts,
        "poses": _poses(flights, found, scatter),
        "drag_per_m": Quantity(drag, drag * _own_sigma(flights, path.DRAG), "1/m").to_json(),
        "chi2_per_dof": flights.chi2_per_dof,
    }


def positions(placed: Placed, times_s: Floats) -> Json:
    """Return places of a ball and their standard errors, frame by frame."""
    return {
        "frame": placed.frames.tolist(),
        "t_s": [float(t) for t in times_s[placed.frames]],
        "row_px": placed.places[:, 0].tolist(),
        "column_px": placed.places[:, 1].tolist(),
        "sigma_row_px": placed.sigmas[:, 0].tolist(),
        "sigma_column_px": placed.sigmas[:, 1].tolist(),
    }


def flight_impact(flights: Flights, bounce: int, found: Coefficient, times_s: Floats) -> Json:
    """Return one bounce: speeds along the plate's normal and beside it, e, and when.

    Signs as in section 7.1 of the thesis with the plate as sphere b: v_n is negative before
    contact. Without markers the spin is open, and with it v_s and beta.
    """
    contact = flights.contacts[bounce]
    frames = flights.observed.frames
    before = frames[flights.used & (flights.arcs == bounce)]
    after = frames[flights.used & (flights.arcs == bounce + 1)]
    value, sigma = found
    along_time = _sigma(flights, bounce, TIME)
    tilt, tilt_sigma = flights.values[path.TILT], _own_sigma(flights, path.TILT)
    reach = float(np.hypot(contact[TOWARDS], contact[BESIDE])) / flights.scale_px_per_m
    surface = abs(contact[BESIDE]) / flights.scale_px_per_m
    return {
        "contact_time_s": float(contact[TIME]),
        "contact_time_sigma_s": along_time,
        "contact_duration": None,
        "frame": frame_at(times_s, float(contact[TIME])),
        "normal": [math.cos(tilt), -math.sin(tilt), 0.0],
        "normal_sigma": [0.0, tilt_sigma, tilt_sigma],
        "v_n": _speed(flights, bounce, TOWARDS, -1.0),
        "v_n_after": _speed(flights, bounce, AWAY, 1.0),
        "v_t": _speed(flights, bounce, BESIDE, 1.0),
        "v_t_after": _speed(flights, bounce, BESIDE_AFTER, 1.0),
        # A surface that spins as fast as the ball flies is the most that is taken for possible.
        "v_s": _open(max(0.0, surface - reach), surface + reach),
        "v_s_after": _open(-surface - reach, surface + reach),
        "e": Quantity(value, sigma, "1").to_json(),
        "beta": None,
        "frames_before": before.tolist(),
        "frames_after": after.tolist(),
    }


def unseen(unit: str) -> Json:
    """Return a quantity that was not measured."""
    return {"value": None, "sigma": None, "unit": unit}


def _open(low: float, high: float) -> Json:
    return unseen("m/s") | {"low": low, "high": high}


def _own_sigma(flights: Flights, index: int) -> float:
    return math.sqrt(max(0.0, float(flights.whole_covariance[index, index])))


def _sigma(flights: Flights, bounce: int, number: int) -> float:
    slope = flights.contact_slopes[bounce, number]
    return math.sqrt(max(0.0, float(slope @ flights.whole_covariance @ slope)))


def _speed(flights: Flights, bounce: int, number: int, sign: float) -> Json:
    """Return a speed in m/s; the scale's error is that of the fall, which the fit shares."""
    scale = flights.scale_px_per_m
    value = float(flights.contacts[bounce, number]) / scale
    slope = flights.contact_slopes[bounce, number].copy()
    slope[path.FALL] -= flights.contacts[bounce, number]
    sigma = math.sqrt(max(0.0, float(slope @ flights.whole_covariance @ slope))) / scale
    return Quantity(sign * value, sigma, "m/s").to_json()


def _camera(flights: Flights) -> Json:
    fall, fall_sigma = flights.scale_of_fall
    size, size_sigma = flights.scale_of_diameter
    told = math.isfinite(fall_sigma)
    ratio = Quantity(fall / size, math.hypot(fall_sigma, size_sigma), "1") if told else None
    values = flights.values
    return {
        "scale_px_per_m": {
            "used": Quantity(
                flights.scale_px_per_m,
                flights.scale_px_per_m * _own_sigma(flights, path.FALL),
                "px/m",
            ).to_json(),
            "from_diameter": Quantity(size, size * size_sigma, "px/m").to_json(),
            "from_gravity": Quantity(fall, fall * fall_sigma, "px/m").to_json() if told else None,
            "gravity_over_diameter": None if ratio is None else ratio.to_json(),
            "agree": not flights.contradiction,
        },
        "plate": {
            "row_px": Quantity(values[path.PLATE], _own_sigma(flights, path.PLATE), "px").to_json(),
            "tilt": Quantity(values[path.TILT], _own_sigma(flights, path.TILT), "rad").to_json(),
        },
        "row_time_s": Quantity(
            values[path.ROW_TIME], _own_sigma(flights, path.ROW_TIME), "s"
        ).to_json(),
        "residual_px": {
            "row": float(np.std(flights.residuals[flights.used, 0])),
            "column": float(np.std(flights.residuals[flights.used, 1])),
        },
    }
