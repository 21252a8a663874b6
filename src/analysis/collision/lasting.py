"""Collision operator of a contact of finite duration: forces integrated from touch to parting."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.collision.contact_block import SPRING
from analysis.collision.contact_loop import UNITS, collide
from analysis.collision.damping import damping
from analysis.collision.force_law import REFERENCE_SPEED, ForceLaw
from analysis.collision.operator import Body, Encounter, Outcome, States, inverse_masses

LEAST_SPEED, LEAST_E, LEAST_RATIO = 1e-3, 0.05, 1e-6
STEPS, STIFFER = 160, ((0.5, 320),)
"""Steps in an undamped duration, and so many where kt/kn is as large as this or larger.

The stiffer across the normal, the faster spheres swing there. Velocities after contact are then
right to some 0.01 mm/s, and kt/kn of filmed shots to a small part of its error: of 36 shots with
kt/kn = 0.15, whose error is 1.4e-5, it is 1e-5 too large with 80 steps and 1e-6 with 160; at 1.1
with 80 steps it is 0.0025 too small, 20 errors of 60 shots.
"""


@dataclass(frozen=True, slots=True)
class Stiffness:
    """Parameters of a contact of finite duration beside e and mu: common, or one per encounter.

    Attributes
    ----------
    duration_s
        Of an undamped contact at an approach of 1 m/s.
    ratio
        Tangential over normal stiffness: 2 (1 - nu) / (2 - nu) for like solids (Mindlin).
    damping
        Tangential damping over its critical value.
    """

    duration_s: float | Floats
    ratio: float | Floats
    damping: float | Floats


def steps_for(ratio: float | Floats) -> int:
    """Return how many steps a stiffness ratio requires; the largest of several decides."""
    largest = float(np.max(ratio))
    return next((steps for least, steps in reversed(STIFFER) if largest >= least), STEPS)


def lasting(
    encounter: Encounter, law: ForceLaw, stiffness: Stiffness, steps: int | None = None
) -> Outcome:
    """Return the outcome of each encounter for a contact of finite duration.

    The relative motion is integrated about the turning line of centres; gravity and air act on both
    spheres alike meanwhile. Beside a plate the normal stays, and gravity pulls the sphere alone. A
    contact that never parts leaves not a number.

    Parameters
    ----------
    steps
        In an undamped duration; None: as many as the stiffness ratio requires.
    """
    steps = steps_for(stiffness.ratio) if steps is None else steps
    a, b = encounter.bodies
    give, give_t = inverse_masses(encounter.bodies)
    before, mass = encounter.before, 1.0 / give
    k = law.normal.stiffness(mass, stiffness.duration_s)
    speed = encounter.approach.clip(min=LEAST_SPEED)
    depth = (mass * speed**2 / k) ** (law.normal.depth_exponent / 2)
    loss = damping(encounter.e.clip(min=LEAST_E), law.normal, steps)
    loss = loss * (speed / REFERENCE_SPEED) ** law.normal.loss_exponent
    dashpot = loss * k * depth ** (law.normal.elastic - law.normal.damping) / speed
    pair = np.array(
        [
            a.radius,
            b.radius,
            give,
            1.0 / a.inertia,
            1.0 / b.inertia,
            (1.0 if b.is_plate else 0.5) if law.shortened else 0.0,
            0.0 if b.is_plate else 1.0,
            encounter.gravity if b.is_plate else 0.0,
        ]
    )
    numbers = np.array(
        [
            law.normal.elastic,
            law.normal.damping,
            1.0 if law.history == "increment" else 0.0,
            1.0 if law.dashpot_slides else 0.0,
        ]
    )
    count = len(encounter.normal)
    units = np.empty((count, UNITS))
    units[:, 0] = k
    units[:, 1] = dashpot
    units[:, 2] = encounter.mu.clip(min=0.0)
    units[:, 3] = np.maximum(stiffness.ratio, LEAST_RATIO)
    units[:, 4] = 2.0 * np.sqrt(1 / give_t) * np.maximum(stiffness.damping, 0.0)
    units[:, 5] = law.normal.elastic_duration * depth / speed
    relative = before.velocity_b - before.velocity_a
    spins = np.stack([before.spin_a, before.spin_b], axis=1)
    touch = _rows(encounter.normal), _rows(relative), _rows(spins)
    ends, durations, turns = collide(touch, pair, numbers, units, steps)
    return _outcome(encounter, (a, b), ends, durations, turns)


def _rows(numbers: Floats) -> Floats:
    """Return numbers as contiguous arrays for a compiled loop."""
    return np.require(numbers, np.float64, ("C", "W"))


def _outcome(
    encounter: Encounter, bodies: tuple[Body, Body], ends: Floats, durations: Floats, turns: Floats
) -> Outcome:
    """Return the outcome from the states at separation (N, 15)."""
    a, b = bodies
    before = encounter.before
    place, velocity, spin_a, spin_b = (ends[:, k : k + 3] for k in range(0, SPRING, 3))
    share_a = 0.0 if b.is_plate else a.mass / (a.mass + b.mass)
    common = share_a * before.velocity_a + (1.0 - share_a) * before.velocity_b
    way = common * durations[:, None]
    apart = place - (a.radius + b.radius) * encounter.normal
    return Outcome(
        after=States(
            common - (1.0 - share_a) * velocity, common + share_a * velocity, spin_a, spin_b
        ),
        duration=durations,
        shift_a=way - (1.0 - share_a) * apart,
        shift_b=way + share_a * apart,
        turn_a=turns[:, 0],
        turn_b=turns[:, 1],
    )
