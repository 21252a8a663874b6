"""The two free flights of a shot: what a sphere does before and after contact, in 48 numbers.

Each side of each sphere is extrapolated to first touch, tau = 0, and follows
x = start + velocity tau + g tau^2 / 2 and R = exp(spin tau) start. Whatever happens at contact acts
on the poses through these numbers alone, so a derivative by the state or by the law is small.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.model.data.poses import Observations
from analysis.model.loops import plain
from analysis.model.loops.sides import add_own, by_outcome
from analysis.model.predict.contact import AFTER, DURATION, SHIFT, TURN
from analysis.model.predict.state import MOTION, SIZE, TILT, ShotStates
from analysis.motion.rotation import rotation_matrix

NUMBERS = 48
"""Two spheres, then position and orientation, then before and after, then start and rate in three
axes: m and m/s, rad and rad/s."""

SIDES = (-1.0, 1.0)
"""Centre of a and of b along the normal from the point of contact, in radii."""


@dataclass(frozen=True, slots=True, eq=False)
class Flights:
    """Both sides of both spheres, S shots.

    Attributes
    ----------
    place, velocity, spin
        At tau = 0, m, m/s, rad/s, shape (S, 2 spheres, 2 sides, 3).
    rotation
        Orientation at tau = 0, body to rig axes, shape (S, 2, 2, 3, 3).
    duration
        Of the contact, s, shape (S,).
    touch
        Orientations at first touch, shape (S, 2, 3, 3).
    """

    place: Floats
    velocity: Floats
    spin: Floats
    rotation: Floats
    duration: Floats
    touch: Floats


def flights(data: Observations, states: ShotStates, outcome: Floats) -> Flights:
    """Return both flights of every shot, from its state and the outcome of its contact (S, 25)."""
    shots = len(outcome)
    place, velocity, spin = (np.empty((shots, 2, 2, 3)) for _ in range(3))
    duration = outcome[:, DURATION]
    before = states.before
    velocity[:, :, 0] = np.stack([before.velocity_a, before.velocity_b], axis=1)
    spin[:, :, 0] = np.stack([before.spin_a, before.spin_b], axis=1)
    after = outcome[:, AFTER].reshape(shots, 4, 3)
    velocity[:, :, 1], spin[:, :, 1] = after[:, :2], after[:, 2:]
    for i in (0, 1):
        place[:, i, 0] = states.point + SIDES[i] * data.bodies[i].radius * states.normal
    shift = outcome[:, SHIFT].reshape(shots, 2, 3)
    place[:, :, 1] = place[:, :, 0] + shift - velocity[:, :, 1] * duration[:, None]
    rotation = np.empty((shots, 2, 2, 3, 3))
    rotation[:, :, 0] = states.rotation
    turn = rotation_matrix(outcome[:, TURN].reshape(shots, 2, 3))
    back = rotation_matrix(-spin[:, :, 1] * duration[:, None])
    rotation[:, :, 1] = back @ turn @ states.rotation
    return Flights(place, velocity, spin, rotation, duration[:, 0], states.rotation)


def place_of_rate(sphere: int, *, spin: bool, after: bool) -> slice:
    """Return where a velocity or spin stands among the 48 numbers."""
    first = 24 * sphere + 12 * spin + 6 * after + 3
    return slice(first, first + 3)


def rates_of(sides: Flights) -> Floats:
    """Return velocities and spins in their places among the 48 numbers, the rest 0, (S, 48)."""
    numbers = np.zeros((len(sides.duration), 2, 2, 2, 2, 3))
    numbers[:, :, 0, :, 1], numbers[:, :, 1, :, 1] = sides.velocity, sides.spin
    return numbers.reshape(-1, NUMBERS)


def flights_by_state(
    data: Observations, states: ShotStates, sides: Flights, outcome: Floats, by_state: Floats
) -> Floats:
    """Differentiate the 48 numbers by the 24 of the shot, shape (S, 48, 24).

    Parameters
    ----------
    sides
        Both flights of every shot.
    outcome, by_state
        Of the contact, shape (S, 25), and its derivatives by tilt and motion, shape (S, 25, 14).
    """
    change = np.zeros((*outcome.shape, SIZE))
    change[..., TILT.start : MOTION.stop] = by_state
    whole = flights_by_outcome(outcome, change)
    reach_a, reach_b = (way * body.radius for way, body in zip(SIDES, data.bodies, strict=True))
    add_own(
        whole,
        states.tangents(),
        (sides.velocity, sides.spin),
        (sides.rotation, plain(sides.touch)),
        (reach_a, reach_b, data.gravity),
    )
    return whole


def flights_by_outcome(outcome: Floats, change: Floats) -> Floats:
    """Return what changes of the outcome (S, 25, K) do to the 48 numbers, shape (S, 48, K)."""
    return by_outcome(plain(outcome), plain(change))
