"""Normal and surface velocities of an impact and its coefficients (thesis, section 7.1)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class ContactState:
    """Both spheres at one instant: velocities (m/s) and spins (rad/s) in rig axes, shape (3,)."""

    velocity_a: Floats
    velocity_b: Floats
    spin_a: Floats
    spin_b: Floats


@dataclass(frozen=True, slots=True)
class ImpactVelocities:
    """The scalars of section 7.1, m/s: `v_n` negative, `v_n_after` positive, `v_s` a length.

    `v_s_after` is the surface velocity after contact along the direction of the incident one;
    `v_s_across` what stands across that direction.
    """

    v_n: float
    v_s: float
    v_n_after: float
    v_s_after: float
    v_s_across: float

    @property
    def e(self) -> float:
        """Coefficient of normal restitution, -v_n' / v_n."""
        return -self.v_n_after / self.v_n

    @property
    def beta(self) -> float:
        """Rotational restitution, -v_s' / v_s; not a number without surface velocity."""
        return -self.v_s_after / self.v_s if self.v_s > 0 else float("nan")


def surface_velocity(state: ContactState, normal: Floats, radii: tuple[float, float]) -> Floats:
    """Return the relative surface velocity at the contact, m/s, shape (3,).

    V_s = V_t + n x (R_a w_a + R_b w_b) with V = V_b - V_a, section 7.1 with a radius for each
    sphere where the thesis has D/2.
    """
    relative = state.velocity_b - state.velocity_a
    tangential = relative - (relative @ normal) * normal
    turning = radii[0] * state.spin_a + radii[1] * state.spin_b
    return np.asarray(tangential + _cross(normal, turning))


def _cross(a: Floats, b: Floats) -> Floats:
    # The library's product of two single vectors takes ten times as long.
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def impact_velocities(
    before: ContactState, after: ContactState, normal: Floats, radii: tuple[float, float]
) -> ImpactVelocities:
    """Return v_n, v_s, v_n', v_s' about the normal (unit vector from a to b)."""
    incident = surface_velocity(before, normal, radii)
    v_s = math.sqrt(float(incident @ incident))
    along = incident / v_s if v_s > 0 else np.zeros(3)
    leaving = surface_velocity(after, normal, radii)
    return ImpactVelocities(
        v_n=float((before.velocity_b - before.velocity_a) @ normal),
        v_s=v_s,
        v_n_after=float((after.velocity_b - after.velocity_a) @ normal),
        v_s_after=float(leaving @ along),
        v_s_across=float(leaving @ _cross(normal, along)),
    )
