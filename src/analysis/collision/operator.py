"""The hard-sphere collision operator: restitution, friction and rotational restitution.

O. R. Walton, "Numerical simulation of inelastic, frictional particle-particle interactions", in
Particulate Two-Phase Flow, ed. M. C. Roco (1993), 884-911; thesis, sections 3.1 and 7.1, with
speeds taken positive. For many collisions at once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from analysis.arrays import Floats
from analysis.material import Material


@dataclass(frozen=True, slots=True)
class Body:
    """A sphere: mass in kg, radius in m, moment of inertia in kg m^2; a plate has infinite ones.

    `material` is None where none is stated.
    """

    mass: float
    radius: float
    inertia: float
    material: Material | None = None

    @classmethod
    def sphere(cls, diameter_m: float, density_kg_per_m3: float, inertia_factor: float) -> Body:
        """Return a sphere with inertia `inertia_factor` m R^2 (0.4 when solid)."""
        radius = diameter_m / 2
        mass = density_kg_per_m3 * np.pi / 6 * diameter_m**3
        return cls(mass, radius, inertia_factor * mass * radius**2)

    @classmethod
    def plate(cls) -> Body:
        """Return a flat surface at rest; its lever arm is 0, since it does not spin."""
        return cls(np.inf, 0.0, np.inf)

    @property
    def is_plate(self) -> bool:
        """Whether it is a plate."""
        return not np.isfinite(self.mass)


@dataclass(frozen=True, slots=True)
class WaltonLaw:
    """Coefficients of the operator.

    Attributes
    ----------
    e
        Normal restitution, 0 to 1.
    mu
        Coulomb friction.
    beta0
        Rotational restitution of a contact that sticks, -1 to 1.
    """

    e: float
    mu: float
    beta0: float


@dataclass(frozen=True, slots=True, eq=False)
class States:
    """Velocities (m/s) and spins (rad/s) of both spheres, rig axes, each of shape (shots, 3)."""

    velocity_a: Floats
    velocity_b: Floats
    spin_a: Floats
    spin_b: Floats


def sticking_or_sliding(encounter: Encounter) -> Floats:
    """Return Walton's impulse across the normal, kg m/s, against the surface velocity, shape (S,).

    A contact that sticks changes the surface velocity v_s by -(1 + beta0) v_s; friction can change
    it by mu times the impulse along the normal at most.
    """
    give_n, give_t = inverse_masses(encounter.bodies)
    impulse_n = (1 + encounter.e) * encounter.approach / give_n
    sticking = (1 + encounter.beta0) * encounter.sliding_speed / give_t
    return np.minimum(sticking, encounter.mu * np.abs(impulse_n))


@dataclass(frozen=True, eq=False)
class Encounter:
    """Two spheres at first touch, in each of S shots, and the law that holds there.

    Attributes
    ----------
    before
        Velocities and spins at first touch.
    normal
        Unit vectors from a to b, shape (S, 3).
    bodies
        Spheres a and b.
    e, mu, beta0
        Coefficients in each shot, shape (S,).
    covariates
        Further columns of each shot by name, each of shape (S,): `order` from -0.5 to 0.5, and
        every numeric column of the shot list.
    across
        The law across the normal: impulse against the surface velocity, kg m/s, shape (S,).
    point
        Contact point, rig axes, m, shape (S, 3); None where not known, as in a table of contacts.
    gravity
        m/s^2 along +X, that acts while a contact beside a plate lasts.
    rotation
        Orientations of a and b, body to rig axes, shape (S, 2, 3, 3); None where not known.
    """

    before: States
    normal: Floats
    bodies: tuple[Body, Body]
    e: Floats
    mu: Floats
    beta0: Floats
    covariates: Mapping[str, Floats]
    across: Callable[[Encounter], Floats] = sticking_or_sliding
    gravity: float = 0.0
    point: Floats | None = None
    rotation: Floats | None = None

    @cached_property
    def approach(self) -> Floats:
        """Approach speed, m/s, positive, shape (S,)."""
        relative = self.before.velocity_b - self.before.velocity_a
        return np.asarray(-(relative * self.normal).sum(axis=1))

    @cached_property
    def sliding(self) -> Floats:
        """Relative surface velocity across the normal, m/s, shape (S, 3)."""
        return surface_velocity(self.before, self.normal, self.bodies)

    @cached_property
    def sliding_speed(self) -> Floats:
        """Magnitude of `sliding`, m/s, kept above zero so that it has a direction, shape (S,)."""
        return _speed(self.sliding)


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """State and displacements after a contact.

    Attributes
    ----------
    after
        Velocities and spins at separation.
    duration
        Time from first touch to separation, s, shape (S,).
    shift_a, shift_b
        How far the centres have moved meanwhile, m, shape (S, 3).
    turn_a, turn_b
        By how much the spheres have turned meanwhile, rad, rig axes, shape (S, 3).
    """

    after: States
    duration: Floats
    shift_a: Floats
    shift_b: Floats
    turn_a: Floats
    turn_b: Floats


Operator = Callable[[Encounter], Outcome]
"""From first touch to separation; an effect of the contact wraps one."""


def surface_velocity(state: States, normal: Floats, bodies: tuple[Body, Body]) -> Floats:
    """Return V_s = V_t + n x (R_a w_a + R_b w_b), m/s, shape (S, 3) (thesis, section 7.1)."""
    relative = state.velocity_b - state.velocity_a
    turning = bodies[0].radius * state.spin_a + bodies[1].radius * state.spin_b
    across = relative - _dot(relative, normal) * normal
    return np.asarray(across + _cross(normal, turning))


def walton(encounter: Encounter) -> Outcome:
    """Return the outcome of each encounter by the instantaneous hard-sphere operator.

    The impulse along the normal reverses the approach with e; the one across it changes the
    surface velocity V_s by -(1 + beta0) V_s, or by what friction can do, mu times the normal
    impulse, whichever is less: v_s' = max(-beta0 v_s, v_s - mu (1 + e) (1 + 1/K) |v_n|).
    """
    give_n, _ = inverse_masses(encounter.bodies)
    impulse_n = (1 + encounter.e) * encounter.approach / give_n
    impulse_t = encounter.across(encounter)
    along = encounter.sliding / encounter.sliding_speed[:, None]
    return after_impulse(
        encounter, impulse_n[:, None] * encounter.normal - impulse_t[:, None] * along
    )


def inverse_masses(bodies: tuple[Body, Body]) -> tuple[float, float]:
    """Return the change of relative velocity by a unit impulse along and across, 1/kg."""
    a, b = bodies
    along = 1 / a.mass + 1 / b.mass
    return along, along + a.radius**2 / a.inertia + b.radius**2 / b.inertia


def after_impulse(encounter: Encounter, impulse: Floats) -> Outcome:
    """Return the outcome of an impulse on b, kg m/s, shape (S, 3), and its reverse on a."""
    after = with_impulse(encounter.before, encounter.normal, encounter.bodies, impulse)
    still = np.zeros_like(encounter.normal)
    return Outcome(after, np.zeros(len(still)), still, still, still, still)


def with_impulse(
    states: States, normal: Floats, bodies: tuple[Body, Body], impulse: Floats
) -> States:
    """Return states after an impulse on b, kg m/s, shape (S, 3), and its reverse on a."""
    a, b = bodies
    twist = _cross(normal, impulse)
    return States(
        velocity_a=states.velocity_a - impulse / a.mass,
        velocity_b=states.velocity_b + impulse / b.mass,
        spin_a=states.spin_a - a.radius / a.inertia * twist,
        spin_b=states.spin_b - b.radius / b.inertia * twist,
    )


def _speed(velocity: Floats) -> Floats:
    """Return the magnitude of velocities, m/s, kept above zero, shape (S, 3) to (S,)."""
    return np.asarray(np.sqrt(np.maximum((velocity**2).sum(axis=1), 1e-30)))


def _cross(first: Floats, second: Floats) -> Floats:
    """Return the vector products of rows, shape (S, 3); for few rows faster than NumPy's."""
    onward, back = (1, 2, 0), (2, 0, 1)
    return np.asarray(first[:, onward] * second[:, back] - first[:, back] * second[:, onward])


def _dot(first: Floats, second: Floats) -> Floats:
    """Return the scalar products of rows, shape (S, 1)."""
    return np.asarray((first * second).sum(axis=-1, keepdims=True))
