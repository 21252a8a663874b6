"""Flight of both spheres: gravity, air, and what pulls them together."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from simulators.challenge.bodies import Bodies
from simulators.challenge.nature import Nature
from simulators.world.description import Environment

Floats = NDArray[np.float64]
Acceleration = Callable[[Floats, Floats, Floats], Floats]
"""From position, velocity and spin, each (S, 2, 3), to acceleration, m/s^2."""

_LONGEST_STEP_S = 1.25e-4
_PULL_FADES_OVER_M = 0.008


def acceleration(nature: Nature, bodies: Bodies, environment: Environment) -> Acceleration:
    """Return the acceleration that this nature gives free spheres."""
    down = _gravity(nature, environment)
    area = np.pi * bodies.radius_m**2
    air = 0.5 * environment.air_density_kg_per_m3 * area / bodies.mass[:, None]
    wind = np.array(nature.wind_m_per_s)

    def accelerate(position: Floats, velocity: Floats, spin: Floats) -> Floats:
        result = np.broadcast_to(down, velocity.shape).copy()
        if nature.drag_coefficient != 0.0:
            through = velocity - wind
            speed = np.linalg.norm(through, axis=-1, keepdims=True)
            result -= nature.drag_coefficient * air * speed * through
        if nature.lift != 0.0:
            result += nature.lift * air * _lift(velocity, spin, bodies.radius_m)
        if nature.pull_m_per_s2 != 0.0:
            result += nature.pull_m_per_s2 * _pull(position, bodies.radius_m)
        if nature.central_m_per_s2 != 0.0:
            fallen = _falling_off(position, bodies.radius_m, nature.central_power)
            result += nature.central_m_per_s2 * fallen
        return result

    return accelerate


def fly(start: tuple[Floats, Floats, Floats], times_s: Floats, accelerate: Acceleration) -> Floats:
    """Follow both spheres of S shots to times that run away from zero, either way.

    Classical Runge-Kutta; each shot has steps of its own, so that every one ends on its frames.

    Parameters
    ----------
    start
        Position, velocity and spin at time zero, each (S, 2, 3); the spin is constant, as air
        takes next to none of it.
    times_s
        (S, F), each row growing or falling from zero on.

    Returns
    -------
    Positions (S, F, 2, 3), m.
    """
    position, velocity, spin = start
    places = np.empty((*times_s.shape, 2, 3))
    now = np.zeros(len(times_s))
    for frame in range(times_s.shape[1]):
        way = times_s[:, frame] - now
        steps = max(int(np.ceil(np.abs(way).max(initial=0.0) / _LONGEST_STEP_S)), 1)
        step = (way / steps)[:, None, None]
        for _ in range(steps):
            position, velocity = _step(position, velocity, spin, step, accelerate)
        now = times_s[:, frame]
        places[:, frame] = position
    return places


def _step(
    position: Floats, velocity: Floats, spin: Floats, step: Floats, accelerate: Acceleration
) -> tuple[Floats, Floats]:
    first = accelerate(position, velocity, spin)
    middle = velocity + 0.5 * step * first
    second = accelerate(position + 0.5 * step * velocity, middle, spin)
    centre = velocity + 0.5 * step * second
    third = accelerate(position + 0.5 * step * middle, centre, spin)
    end = velocity + step * third
    fourth = accelerate(position + step * centre, end, spin)
    return (
        position + step / 6.0 * (velocity + 2.0 * middle + 2.0 * centre + end),
        velocity + step / 6.0 * (first + 2.0 * second + 2.0 * third + fourth),
    )


def _gravity(nature: Nature, environment: Environment) -> Floats:
    right, near = np.sin(nature.gravity_tilt_rad)
    direction = np.array([np.sqrt(1.0 - right**2 - near**2), right, near])
    return environment.gravity_m_per_s2 * direction


def _lift(velocity: Floats, spin: Floats, radius_m: float) -> Floats:
    """Return C_L v^2 along spin x velocity, m^2/s^2, with C_L = S / (2.2 S + 0.7).

    S = R |spin x velocity| / v^2; the form follows wind-tunnel data of balls (Nathan,
    Am. J. Phys. 76 (2008) 119, doi:10.1119/1.2805242).
    """
    square = (velocity**2).sum(axis=-1, keepdims=True)
    side = np.cross(spin, velocity)
    length = np.linalg.norm(side, axis=-1, keepdims=True)
    # C_L v^2 side / |side| with |side| cancelled, so that a sphere without spin needs no case.
    ratio = radius_m * length / np.maximum(square, 1e-12)
    return np.asarray(radius_m * side / (2.2 * ratio + 0.7))


def _falling_off(position: Floats, radius_m: float, power: float) -> Floats:
    """Return vectors toward the other sphere, of length (2 R / distance)^power."""
    apart = position[:, 1] - position[:, 0]
    distance = np.linalg.norm(apart, axis=-1, keepdims=True)
    toward = apart / distance * (2.0 * radius_m / distance) ** power
    return np.stack([toward, -toward], axis=1)


def _pull(position: Floats, radius_m: float) -> Floats:
    """Return unit vectors toward the other sphere, fading exponentially with the gap."""
    apart = position[:, 1] - position[:, 0]
    distance = np.linalg.norm(apart, axis=-1, keepdims=True)
    gap = np.maximum(distance - 2.0 * radius_m, 0.0)
    toward = apart / distance * np.exp(-gap / _PULL_FADES_OVER_M)
    return np.stack([toward, -toward], axis=1)
