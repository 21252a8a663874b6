"""Places of a bouncing ball in the picture: flight under gravity and drag, bounces on a plate.

Lengths are pixels in the plane of the flight at the plate; down is positive. A camera that looks
down or up sees higher places smaller, and a rolling shutter sees lower ones later.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.compiled import compiled, part

TIME, SPEED, PLACE, ACROSS, FALL, DRAG, ROW_TIME, PERSPECTIVE, ROLL = range(9)
PLATE, TILT, STAY, DEPTH, BIAS, BARREL, MIDDLE_ROW, MIDDLE_COLUMN, SHORTENING = range(9, 18)
ASLANT, HALF, OUTLINE = 18, 19, 20
PRINCIPAL, LEVEL = [MIDDLE_ROW, MIDDLE_COLUMN], [TILT, ROLL]
"""First contact's time, approach speed, column from the middle and speed across before it; fall,
px/s^2; drag, 1/px; time a row or column, s; perspective, 1/px; the vertical's angle in the picture;
row of contact; angle of the plate in the picture, a quarter turn for a wall, whose sum with the
vertical's is its slope against the horizontal; duration of the first contact, s;
speed away from the camera before it, in distances of the camera a second; shift of a smeared ball's
centre along the rows by its speed, s; barrel distortion at half the picture's larger side; the
principal point, about which it acts as perspective does; power of the approach speed by which
contacts last shorter: 1/5 by H. Hertz (1881), 0 by a linear spring; squared larger side of the
picture over the focal length, which `outlines` takes; half of that side; how much larger the ball
is than the radius with which its places were fitted, relative."""
COMMON = 21
EACH = 3
"""For each bounce: speeds away from the plate and across, what it gains away from the camera."""
LARGEST_STEP_S = 0.02
LEAST_ASLANT = 1e-3
"""Of focal lengths of thirty sides of the picture."""
SLOWEST = 1e-2
"""Approach speeds in that of the first contact: slower ones last no longer."""
SHORTEST_S, LONGEST_FILMS = 1e-6, 2.0
"""A flight's time from bounce to bounce, the most in lengths of the film: numbers that a fit tries
on its way may have no fall, or a ball that leaves the plate downward."""


@part
def _acceleration(down: float, across: float, forces: NDArray[np.float64]) -> tuple[float, float]:
    """Return the accelerations down and across at these speeds."""
    braking = forces[2] * math.sqrt(down * down + across * across)
    return forces[0] - braking * down, forces[1] - braking * across


@part
def _fly(state: NDArray[np.float64], time: float, forces: NDArray[np.float64]) -> None:
    """Move a state (down, across, and their speeds) on by a time of either sign (Runge-Kutta).

    Forces are the fall down and across, px/s^2, and the drag, 1/px.
    """
    steps = 1 + int(abs(time) / LARGEST_STEP_S)
    h = time / steps
    down, across = state[2], state[3]
    for _ in range(steps):
        a, b = _acceleration(down, across, forces)
        down_2, across_2 = down + 0.5 * h * a, across + 0.5 * h * b
        a_2, b_2 = _acceleration(down_2, across_2, forces)
        down_3, across_3 = down + 0.5 * h * a_2, across + 0.5 * h * b_2
        a_3, b_3 = _acceleration(down_3, across_3, forces)
        down_4, across_4 = down + h * a_3, across + h * b_3
        a_4, b_4 = _acceleration(down_4, across_4, forces)
        state[0] += (h / 6.0) * (down + 2.0 * (down_2 + down_3) + down_4)
        state[1] += (h / 6.0) * (across + 2.0 * (across_2 + across_3) + across_4)
        down += (h / 6.0) * (a + 2.0 * (a_2 + a_3) + a_4)
        across += (h / 6.0) * (b + 2.0 * (b_2 + b_3) + b_4)
    state[2], state[3] = down, across


@part
def _meet(state: NDArray[np.float64], tilt: float, lasts: float, forces: Floats) -> float:
    """Move a state on to where it meets the plate again; return how long that takes.

    `lasts` is a first guess; the rest are Newton's steps.
    """
    level, begun = state[0], state[1]
    normal_down, normal_across = math.cos(tilt), -math.sin(tilt)
    _fly(state, lasts, forces)
    guess = lasts
    for _ in range(12):
        above = (state[0] - level) * normal_down + (state[1] - begun) * normal_across
        closing = state[2] * normal_down + state[3] * normal_across
        if abs(closing) < 1e-6:
            break
        step = min(max(-above / closing, -0.5 * guess), 0.5 * guess)
        _fly(state, step, forces)
        lasts += step
        if abs(step) < 1e-12:
            break
    return lasts


@part
def _go_on(came: Floats, left: Floats, lasts: float, tilt: float) -> None:
    """Fill in where a ball leaves a plate, along which it goes on at the mean of its two speeds.

    Parameters
    ----------
    came, left
        States before and after a contact, of which the places of the second are filled in.
    lasts
        How long the contact does, s.
    """
    slope = math.tan(tilt)
    down, across = 0.5 * (came[2] + left[2]) * lasts, 0.5 * (came[3] + left[3]) * lasts
    if abs(slope) < 1.0:
        left[0], left[1] = came[0] + across * slope, came[1] + across
    else:
        left[0], left[1] = came[0] + down, came[1] + down / slope


@part
def _lengthened(first: float, speed: float, power: float) -> float:
    """Return how much longer a contact lasts than that of the first approach speed."""
    if first <= 0.0 or speed <= 0.0:
        return 1.0
    return float((first / max(speed, SLOWEST * first)) ** power)


@compiled
def rise(values: NDArray[np.float64]) -> float:
    """Return by how much higher what drifts away is seen, px by a distance of the camera.

    A camera that looks down at an angle whose sine is s and whose focal length is f px has
    perspective s / f and a rise of s f.
    """
    side = 2.0 * values[HALF]
    return float(values[PERSPECTIVE] * side**2 / max(values[ASLANT], LEAST_ASLANT))


@part
def _seen(values: NDArray[np.float64], found: NDArray[np.float64]) -> None:
    """Turn places on the plane of flight, and what distance drift has added, into the picture."""
    plate = values[PLATE] - values[MIDDLE_ROW]
    half = values[HALF]
    higher = rise(values)
    for n in range(len(found)):
        distance = 1.0 + values[PERSPECTIVE] * found[n, 0] + found[n, 2]
        down = (plate + found[n, 0] - higher * found[n, 2]) / distance
        across = found[n, 1] / distance
        bent = 1.0 + values[BARREL] * (down * down + across * across) / half**2
        found[n, 0] = values[MIDDLE_ROW] + bent * down
        found[n, 1] = values[MIDDLE_COLUMN] + bent * across
        found[n, 2] = distance


@compiled
def places(
    values: NDArray[np.float64],
    times: NDArray[np.float64],
    arcs: NDArray[np.intp],
    found: NDArray[np.float64],
    contacts: NDArray[np.float64],
) -> None:
    """Fill in where a ball is seen, for each of several sets of numbers.

    Parameters
    ----------
    values
        COMMON numbers and EACH for each bounce; shape (P, K).
    times
        At which the ball's rows were read, s, increasing; shape (P, N).
    arcs
        Which flight each belongs to: 0 before the first bounce; shape (N,).
    found
        Row, column, and the distance in its value at the first contact, shape (P, N, 3).
    contacts
        Of each bounce time, speed towards the plate, across before, speed away, across after,
        along the plate's normal and beside it, and its column. Shape (P, bounces, 6).
    """
    for p in range(len(values)):
        _place(values[p], times[p], arcs, found[p], contacts[p])


@part
def _place(
    values: NDArray[np.float64],
    times: NDArray[np.float64],
    arcs: NDArray[np.intp],
    found: NDArray[np.float64],
    contacts: NDArray[np.float64],
) -> None:
    """Fill in where a ball is seen, for one set of numbers."""
    forces = np.empty(3)
    forces[0] = values[FALL] * math.cos(values[ROLL])
    forces[1] = values[FALL] * math.sin(values[ROLL])
    forces[2] = values[DRAG]
    normal_down, normal_across = math.cos(values[TILT]), -math.sin(values[TILT])
    longest = LONGEST_FILMS * (times.max() - times.min()) + LARGEST_STEP_S
    state, start = np.empty(4), np.empty(4)
    # Before the first bounce, backward from it.
    start[0], start[1] = 0.0, values[PLACE]
    start[2], start[3] = values[SPEED], values[ACROSS]
    begun = values[TIME]
    state[:] = start
    at = begun
    for n in range(len(times) - 1, -1, -1):
        if arcs[n] == 0:
            _fly(state, times[n] - at, forces)
            at = times[n]
            found[n, 0], found[n, 1] = state[0] + values[BIAS] * abs(state[2]), state[1]
            found[n, 2] = values[DEPTH] * (times[n] - begun)
    state[:] = start
    depth, receding = 0.0, values[DEPTH]
    for k in range(len(contacts)):
        own = COMMON + EACH * k
        away, beside = values[own], values[own + 1]
        receding += values[own + 2]
        contacts[k, 0] = begun
        contacts[k, 1] = state[2] * normal_down + state[3] * normal_across
        contacts[k, 2] = state[3] * normal_down - state[2] * normal_across
        contacts[k, 3] = away * normal_down - beside * normal_across
        contacts[k, 4] = beside * normal_down + away * normal_across
        contacts[k, 5] = state[1]
        lasts = values[STAY] * _lengthened(contacts[0, 1], contacts[k, 1], values[SHORTENING])
        start[2], start[3] = -away, beside
        _go_on(state, start, lasts, values[TILT])
        begun += lasts
        state[:] = start
        at = begun
        for n in range(len(times)):
            if arcs[n] == k + 1:
                _fly(state, times[n] - at, forces)
                at = times[n]
                found[n, 0], found[n, 1] = state[0] + values[BIAS] * abs(state[2]), state[1]
                found[n, 2] = depth + receding * (at - begun)
        state[:] = start
        pull = forces[0] * normal_down + forces[1] * normal_across
        # Too long rather than too short: from there Newton's steps do not end at the bounce before.
        guess = 2.0 * max(away, contacts[k, 3]) / max(pull, 1e-9)
        lasted = _meet(state, values[TILT], min(max(guess, SHORTEST_S), longest), forces)
        begun += lasted
        depth += receding * lasted
    _seen(values, found)
