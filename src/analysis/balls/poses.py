"""Places of a bouncing ball in rig axes: what the camera does to them is taken out.

X is along gravity and Y across the picture, both from the first contact. Where along the line of
sight a ball is, one view does not tell.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from analysis.arrays import Floats
from analysis.balls.flight import path
from analysis.balls.flight.flights import Flights
from analysis.balls.measuring import MeasuredBall, coefficient
from analysis.motion.drift import WORST_LENGTH, line_variances

Json = dict[str, Any]

UNBENDING = 8
"""Steps in which a lens's bending of a few per cent is undone to rounding."""
LEAST_E = 3e-4
"""Error of e whose bent flights are the least that single films leave: radius, outlines and light
bend flights in ways that e does not feel, and the drag of the air does."""


def ball_poses(measured: MeasuredBall, flights: Flights) -> Json:
    """Return times and places of a ball in rig axes, and what all of them share.

    The errors of single places are those beside one another; `slow_m` is what the places of one
    flight share. `scale_sigma` is what the ball's diameter leaves of the scale, or gravity where
    the two contradict each other; `normal` is that of the plate.
    """
    observed, used = flights.observed, flights.used
    scale = flights.scale_px_per_m
    times = observed.times_s + flights.row_delay(observed.places)
    places = _upright(flights, _in_plane(flights, times)) / scale
    distance = flights.at(times, flights.arcs)[:, 2]
    sigmas = measured.scatter * distance[:, None] / scale
    lean = float(flights.values[path.TILT] + flights.values[path.ROLL])
    by_size = flights.scale_of_fall if flights.contradiction else flights.scale_of_diameter
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
        "slow_m": float(np.median([_slow(measured, flights, k) for k in range(flights.bounces)])),
    }


def _slow(measured: MeasuredBall, flights: Flights, bounce: int) -> float:
    """Return the error of places that leaves e of a bounce as uncertain as the film does, m.

    Rolling shutter, lens, line of sight and light bend flights; no scatter of places shows it. A
    fit of poses takes such errors of a ball without spin to make rates worst.
    """
    sigma = math.hypot(coefficient(measured, bounce)[1], LEAST_E)
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
