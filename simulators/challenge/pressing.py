"""A contact that takes its time: Hertz's force, damped, followed from first touch on.

The tangential force is a constant part of the normal one, so that both share their course in time
and the contact differs from an instantaneous one by its duration alone. Meanwhile the spheres roll
about each other and the line of centres turns.

References
----------
Mueller, Poeschel, Granular Matter 14 (2012) 115-120.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulators.challenge.bodies import Bodies
from simulators.challenge.coefficients import Coefficients
from simulators.challenge.flight import Acceleration
from simulators.challenge.impact import slip_direction
from simulators.challenge.launch import Touch
from simulators.world.force import damping_ratio

Floats = NDArray[np.float64]

_YOUNGS_MODULUS_PA, _POISSONS_RATIO = 3.0e9, 0.4
_STEPS = 500
_SIDES = np.array([-1.0, 1.0])[:, None]
_HERTZ_DURATIONS = 1.15
"""Followed for this long, when every contact has parted."""


@dataclass(frozen=True, slots=True, eq=False)
class Passage:
    """Both spheres from first touch until they are apart.

    Parameters
    ----------
    ends_s
        How long each shot was followed, (S,); the T times are evenly spaced up to it.
    position, turned
        Centres, m, and rotation vectors since the touch, rad, (T, S, 2, 3).
    velocity, spin
        At the end, (S, 2, 3).
    """

    ends_s: Floats
    position: Floats
    turned: Floats
    velocity: Floats
    spin: Floats

    def at(self, course: Floats, since_s: Floats) -> Floats:
        """Return one of its courses (T, S, 2, 3) at times since the touch (S, F), (S, F, 2, 3).

        Before the first of its times and after the last it stands still.
        """
        last = len(course) - 1
        ends = self.ends_s[:, None]
        share = np.divide(since_s, ends, out=np.ones_like(since_s), where=ends > 0.0)
        place = last * np.clip(share, 0.0, 1.0)
        step = np.minimum(place.astype(np.intp), last - 1)
        part = (place - step)[..., None, None]
        shot = np.arange(len(since_s))[:, None]
        return np.asarray((1.0 - part) * course[step, shot] + part * course[step + 1, shot])


def hertz_duration(approach: Floats, bodies: Bodies, softness: float) -> Floats:
    """Return the duration of an elastic contact (S,), s, `softness` times that of solid nylon."""
    reduced = 1.0 / bodies.normal_mobility
    stiffness = _stiffness(bodies, softness)
    deepest = (5.0 * reduced * approach**2 / (4.0 * stiffness)) ** 0.4
    return np.asarray(2.94 * deepest / approach)


def press(
    touch: Touch,
    held: Coefficients,
    ratio: Floats,
    bodies: Bodies,
    *,
    softness: float,
    outer: Acceleration,
) -> Passage:
    """Integrate the contacts of all shots; `ratio` (S,) is tangential over normal force.

    Midpoint rule. The levers end midway between the centres, so that angular momentum is kept.
    """
    force = _Force(held, (ratio, -slip_direction(touch, bodies)), bodies, softness)
    ends = _HERTZ_DURATIONS * hertz_duration(touch.approach, bodies, softness)
    step = (ends / _STEPS)[:, None, None]
    position = touch.point[:, None] + bodies.radius_m * _SIDES * touch.normal[:, None]
    velocity, spin, turned = touch.velocity, touch.spin, np.zeros_like(touch.spin)
    places, turns = [position], [turned]
    for _ in range(_STEPS):
        push, whirl = force(position, velocity)
        push = push + outer(position, velocity, spin)
        half = velocity + 0.5 * step * push
        middle = position + 0.5 * step * velocity
        push, whirl = force(middle, half)
        push = push + outer(middle, half, spin)
        position = position + step * half
        velocity = velocity + step * push
        turned = turned + step * (spin + 0.5 * step * whirl)
        spin = spin + step * whirl
        places.append(position)
        turns.append(turned)
    return Passage(ends, np.array(places), np.array(turns), velocity, spin)


class _Force:
    """Accelerations, linear and angular, that the contact gives both spheres.

    `drag` is the part of the normal force that acts tangentially (S,), and where to (S, 3).
    """

    def __init__(
        self,
        held: Coefficients,
        drag: tuple[Floats, Floats],
        bodies: Bodies,
        softness: float,
    ) -> None:
        self.bodies = bodies
        self.ratio, self.against = drag[0][:, None], drag[1]
        self.stiffness = _stiffness(bodies, softness)
        share = np.array([damping_ratio(float(e)) for e in held.restitution])
        self.damping = share * np.sqrt(5.0 * self.stiffness / bodies.normal_mobility)

    def __call__(self, position: Floats, velocity: Floats) -> tuple[Floats, Floats]:
        apart = position[:, 1] - position[:, 0]
        distance = np.linalg.norm(apart, axis=1)
        normal = apart / distance[:, None]
        opening = np.einsum("si,si->s", velocity[:, 1] - velocity[:, 0], normal)
        depth = np.maximum(2.0 * self.bodies.radius_m - distance, 0.0)
        push = self.stiffness * depth**1.5 - self.damping * depth**0.25 * opening
        push = np.maximum(push, 0.0)
        across = self.against - np.einsum("si,si->s", self.against, normal)[:, None] * normal
        length = np.linalg.norm(across, axis=1, keepdims=True)
        across = np.divide(across, length, out=np.zeros_like(across), where=length > 0.0)
        force = push[:, None] * (normal + self.ratio * across)
        moment = -0.5 * distance[:, None] * np.cross(normal, force)
        return (
            force[:, None] * _SIDES / self.bodies.mass[:, None],
            moment[:, None] / self.bodies.inertia[:, None],
        )


def _stiffness(bodies: Bodies, softness: float) -> float:
    """Return k of F = k d^(3/2), N m^-1.5; a contact lasts as k^(-2/5)."""
    modulus = _YOUNGS_MODULUS_PA / (2.0 * (1.0 - _POISSONS_RATIO**2))
    solid = 4.0 / 3.0 * modulus * float(np.sqrt(bodies.radius_m / 2.0))
    return solid * float(softness**-2.5)
