"""Normal and surface velocities of an impact and its coefficients (thesis, section 7.1).

For one impact or for many at once: velocities and normals have shape (..., 3), scalars (...).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats


@dataclass(frozen=True, slots=True, eq=False)
class ContactState:
    """Both spheres at one instant: velocities (m/s) and spins (rad/s) in rig axes."""

    velocity_a: Floats
    velocity_b: Floats
    spin_a: Floats
    spin_b: Floats


@dataclass(frozen=True, slots=True, eq=False)
class ImpactVelocities:
    """The scalars of section 7.1, m/s: `v_n` negative, `v_n_after` positive, `v_s` a length.

    `v_s_after` is the surface velocity after contact along the direction of the incident one;
    `v_s_across` its component across that direction.
    """

    v_n: Floats
    v_s: Floats
    v_n_after: Floats
    v_s_after: Floats
    v_s_across: Floats

    @property
    def e(self) -> Floats:
        """Coefficient of normal restitution, -v_n' / v_n."""
        return -self.v_n_after / self.v_n

    @property
    def beta(self) -> Floats:
        """Rotational restitution, -v_s' / v_s; not a number without surface velocity."""
        return -self.v_s_after / np.where(self.v_s > 0.0, self.v_s, np.nan)


def surface_velocity(state: ContactState, normal: Floats, radii: tuple[float, float]) -> Floats:
    """Return the relative surface velocity at the contact, m/s, shape (..., 3).

    V_s = V_t + n x (R_a w_a + R_b w_b) with V = V_b - V_a, section 7.1 with a radius for each
    sphere where the thesis has D/2.
    """
    relative = state.velocity_b - state.velocity_a
    tangential = relative - _dot(relative, normal)[..., None] * normal
    turning = radii[0] * state.spin_a + radii[1] * state.spin_b
    return np.asarray(tangential + np.cross(normal, turning))


def _dot(a: Floats, b: Floats) -> Floats:
    return np.asarray((a * b).sum(axis=-1))


def impact_velocities(
    before: ContactState, after: ContactState, normal: Floats, radii: tuple[float, float]
) -> ImpactVelocities:
    """Return v_n, v_s, v_n', v_s' about the normal (unit vector from a to b)."""
    incident = surface_velocity(before, normal, radii)
    v_s = np.sqrt(_dot(incident, incident))
    along = incident / np.where(v_s > 0.0, v_s, 1.0)[..., None]
    leaving = surface_velocity(after, normal, radii)
    return ImpactVelocities(
        v_n=_dot(before.velocity_b - before.velocity_a, normal),
        v_s=v_s,
        v_n_after=_dot(after.velocity_b - after.velocity_a, normal),
        v_s_after=_dot(leaving, along),
        v_s_across=_dot(leaving, np.cross(normal, along)),
    )
