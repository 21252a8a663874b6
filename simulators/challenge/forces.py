"""Contacts of every kind that simulation codes use, followed in time by their forces.

Along the normal F = k d^p + c d^q d', never pulling. Across it a spring and a dashpot under
Coulomb's limit, or a row of bristles that stick and slip each by itself under a parabolic load.

References
----------
Cundall, Strack, Geotechnique 29 (1979) 47-65; Tsuji, Tanaka, Ishida, Powder Technology 71 (1992)
239-250; Kuwabara, Kono, Jpn. J. Appl. Phys. 26 (1987) 1230; Popov, Hess, Method of Dimensionality
Reduction (2015).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from simulators.challenge.bodies import Bodies
from simulators.challenge.coefficients import Coefficients
from simulators.challenge.flight import Acceleration
from simulators.challenge.force_choice import Forces, Pushing
from simulators.challenge.launch import Touch
from simulators.challenge.pressing import Passage

Floats = NDArray[np.float64]

_EXPONENTS: dict[Pushing, tuple[float, float]] = {
    "tsuji": (1.5, 0.25),
    "viscous": (1.5, 0.5),
    "hertz-dashpot": (1.5, 0.0),
    "linear": (1.0, 0.0),
}
_REFERENCE_SPEED = 2.0
_STEPS, _LONGEST = 500, 1.6
_BRISTLES = 40
_LOSSES = np.linspace(0.0, 2.5, 1001)
_SIDES = np.array([-1.0, 1.0])[:, None]


def press_by(
    forces: Forces, touch: Touch, held: Coefficients, bodies: Bodies, outer: Acceleration
) -> Passage:
    """Integrate the contacts of all shots by the midpoint rule until every one has parted.

    Restitution is that at 2 m/s where the law's own depends on speed.

    Raises
    ------
    RuntimeError
        A contact has not parted after 1.6 of its undamped durations.
    """
    law = _Law(forces, touch, held, bodies)
    steps = int(_LONGEST * _STEPS)
    state = _State.at(touch, bodies, law.elements)
    places, turns, step = [state.position], [state.turned], law.lasting[:, None, None] / _STEPS
    for _ in range(steps):
        first = law.rates(state, outer)
        middle = state.moved(state, first, 0.5 * step)
        cut = middle.spring.copy()
        second = law.rates(middle, outer)
        state = state.moved(middle, second, step)
        # What slips at the middle of a step has slipped at its end.
        state.spring += middle.spring - cut
        places.append(state.position)
        turns.append(state.turned)
    if (law.depth(state) > 0).any():
        raise RuntimeError("a contact has not parted in its time")
    return Passage(
        law.lasting * steps / _STEPS,
        np.array(places),
        np.array(turns),
        state.velocity,
        state.spin,
    )


@dataclass(slots=True, eq=False)
class _State:
    """Centres, velocities, spins and turns (S, 2, 3), springs (S, elements, 3)."""

    position: Floats
    velocity: Floats
    spin: Floats
    turned: Floats
    spring: Floats

    @classmethod
    def at(cls, touch: Touch, bodies: Bodies, elements: int) -> _State:
        position = touch.point[:, None] + bodies.radius_m * _SIDES * touch.normal[:, None]
        still = np.zeros_like(touch.spin)
        return cls(
            position, touch.velocity, touch.spin, still, np.zeros((len(position), elements, 3))
        )

    def moved(self, at: _State, rates: tuple[Floats, Floats, Floats], step: Floats) -> _State:
        """Return the state a step on, with the rates of the state `at`."""
        push, whirl, slide = rates
        return _State(
            self.position + step * at.velocity,
            self.velocity + step * push,
            self.spin + step * whirl,
            self.turned + step * at.spin,
            self.spring + step * slide,
        )


class _Law:
    """Forces between the spheres of all shots."""

    def __init__(self, forces: Forces, touch: Touch, held: Coefficients, bodies: Bodies) -> None:
        self.forces, self.bodies, self.friction = forces, bodies, held.friction
        self.p, self.q = _EXPONENTS[forces.push]
        mass = 1.0 / bodies.normal_mobility
        whole = _undamped(self.p)
        self.stiffness = mass / (forces.duration_s / whole) ** (self.p + 1.0)
        speed = touch.approach
        depth = (mass * speed**2 / self.stiffness) ** (1.0 / (self.p + 1.0))
        self.lasting = whole * depth / speed
        at_two = (mass * _REFERENCE_SPEED**2 / self.stiffness) ** (1.0 / (self.p + 1.0))
        loss = _loss(self.p, self.q, held.restitution)
        self.damping = loss * self.stiffness * at_two ** (self.p - self.q) / _REFERENCE_SPEED
        self.tangential_mass = 1.0 / bodies.surface_mobility
        self.elements = _BRISTLES if forces.drag == "bristles" else 1

    def depth(self, state: _State) -> Floats:
        """Return the overlaps, m, (S,)."""
        apart = np.linalg.norm(state.position[:, 1] - state.position[:, 0], axis=1)
        return np.asarray(2.0 * self.bodies.radius_m - apart)

    def rates(self, state: _State, outer: Acceleration) -> tuple[Floats, Floats, Floats]:
        """Return accelerations, (S, 2, 3), and slips (S, elements, 3); cut springs that slip."""
        apart = state.position[:, 1] - state.position[:, 0]
        distance = np.linalg.norm(apart, axis=1)
        normal = apart / distance[:, None]
        depth = np.maximum(2.0 * self.bodies.radius_m - distance, 0.0)
        relative = state.velocity[:, 1] - state.velocity[:, 0]
        opening = np.einsum("si,si->s", relative, normal)
        elastic = self.stiffness * depth**self.p
        push = np.maximum(elastic - self.damping * depth**self.q * opening, 0.0) * (depth > 0)
        arm = self.bodies.radius_m - (0.0 if self.forces.whole_levers else 0.5) * depth
        slip = relative - opening[:, None] * normal
        slip -= np.cross(arm[:, None] * state.spin.sum(axis=1), normal)
        drag = self._drag(state, normal, slip, depth, push)
        force = push[:, None] * normal + drag
        pushed = force[:, None] * _SIDES / self.bodies.mass[:, None]
        pushed = pushed + outer(state.position, state.velocity, state.spin)
        moment = arm[:, None] * np.cross(drag, normal)
        gain = slip[:, None] * np.ones((1, self.elements, 1))
        if self.forces.drag in {"increment", "damped-while-sticking"}:
            gain = gain * self._tangent(depth)[:, None, None]
        return pushed, moment[:, None] / self.bodies.inertia[:, None], gain

    def _tangent(self, depth: Floats) -> Floats:
        slope = self.p * self.stiffness * depth ** (self.p - 1.0) * (depth > 0)
        return np.asarray(self.forces.stiffness_ratio * slope)

    def _drag(
        self, state: _State, normal: Floats, slip: Floats, depth: Floats, push: Floats
    ) -> Floats:
        """Return the tangential force (S, 3) and leave no spring longer than friction holds."""
        across = state.spring - (state.spring @ normal[:, :, None]) * normal[:, None]
        tangent, limit = self._tangent(depth), self.friction * push
        dashpot = 2 * self.forces.damping_ratio * np.sqrt(tangent * self.tangential_mass)
        if self.forces.drag == "bristles":
            # Each bristle carries its part of a parabolic load over the contact's width.
            place = (np.arange(_BRISTLES) + 0.5) / _BRISTLES
            load = 1.5 * (1 - place**2) / _BRISTLES
            load /= load.sum()
            state.spring = _cut(across, limit[:, None] * load, tangent[:, None] / _BRISTLES)
            force = -(tangent[:, None] / _BRISTLES * state.spring.sum(axis=1))
        elif self.forces.drag == "elongation":
            state.spring = _cut(across, limit[:, None], tangent[:, None])
            force = -tangent[:, None] * state.spring[:, 0]
        else:
            state.spring = _cut(across, limit[:, None], np.ones((1, 1)))
            force = -state.spring[:, 0]
            if self.forces.drag == "damped-while-sticking":
                held = np.linalg.norm(across[:, 0], axis=1) < limit
                dashpot = dashpot * held
        force = force - dashpot[:, None] * slip
        return np.asarray(_cut(force[:, None], limit[:, None], np.ones((1, 1)))[:, 0])


def _cut(springs: Floats, limit: Floats, stiffness: Floats) -> Floats:
    """Shorten springs (S, E, 3) whose force is above a limit (S, E)."""
    size = np.linalg.norm(springs, axis=2) * stiffness
    share = np.divide(limit, size, out=np.ones_like(size + limit), where=size > limit)
    return np.asarray(springs * share[..., None])


@lru_cache
def _undamped(p: float) -> float:
    """Return the duration of an undamped contact where mass, stiffness and speed are 1."""
    depth, speed, time, step = 0.0, 1.0, 0.0, 1e-4
    while depth >= 0.0:
        half = speed - 0.5 * step * max(depth, 0.0) ** p
        speed -= step * max(depth + 0.5 * step * half, 0.0) ** p
        depth += step * half
        time += step
    return time + depth / 1.0


def _loss(p: float, q: float, restitution: Floats) -> Floats:
    """Return the damping that leaves each restitution, where mass, stiffness and speed are 1."""
    return np.asarray(np.interp(restitution, _rebounds(p, q)[::-1], _LOSSES[::-1]))


@lru_cache
def _rebounds(p: float, q: float) -> Floats:
    """Return the restitution of each damping, the force followed until it is gone."""
    depth, speed, step = np.zeros_like(_LOSSES), np.ones_like(_LOSSES), 1e-3
    left = np.full_like(_LOSSES, np.nan)

    def pull(x: Floats, v: Floats) -> Floats:
        x = np.maximum(x, 0.0)
        return np.asarray(-(x**p) - _LOSSES * x**q * v)

    while np.isnan(left).any():
        before = pull(depth, speed)
        middle = pull(depth + 0.5 * step * speed, speed + 0.5 * step * before)
        depth = depth + step * (speed + 0.5 * step * before)
        earlier, speed = speed, speed + step * middle
        after = pull(depth, speed)
        gone = np.isnan(left) & (speed < 0) & (after >= 0)
        share = before / np.where(gone, before - after, 1.0)
        left = np.where(gone, -(earlier + share * (speed - earlier)), left)
    return left
