"""The impulses that two spheres exchange, and what they leave behind."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulators.challenge.bodies import Bodies
from simulators.challenge.bristles import impulse_ratio
from simulators.challenge.coefficients import Coefficients
from simulators.challenge.launch import Touch
from simulators.challenge.nature import Nature
from simulators.challenge.viscoelastic import REFERENCE_SPEED_M_PER_S

Floats = NDArray[np.float64]

Motions = tuple[Floats, Floats]
"""Velocities, m/s, and spins, rad/s, of both spheres, each (S, 2, 3)."""


def normal_impulse(touch: Touch, held: Coefficients, bodies: Bodies) -> Floats:
    """Return the impulse (S,), kg m/s, that turns the approach into its e-fold retreat."""
    return (1.0 + held.restitution) * touch.approach / bodies.normal_mobility


def grip(nature: Nature, touch: Touch, held: Coefficients, bodies: Bodies) -> Floats:
    """Return the ratio (S,) of the tangential to the normal impulse, against the slip.

    A hard contact either slides throughout, mu, or reverses its slip with beta0, whichever asks
    for less.
    """
    slip = np.linalg.norm(touch.slip(bodies.radius_m), axis=1)
    push = normal_impulse(touch, held, bodies)
    reverse = (1.0 + held.rolling_restitution) * slip / bodies.surface_mobility
    hard = np.minimum(held.friction, reverse / push)
    if nature.compliance == 0.0:
        return np.asarray(hard)
    soft = impulse_ratio(
        slip / touch.approach,
        held.restitution,
        held.friction,
        bodies.surface_mobility / bodies.normal_mobility,
    )
    return np.asarray(hard + nature.compliance * (soft - hard))


def strike(touch: Touch, held: Coefficients, ratio: Floats, bodies: Bodies) -> Motions:
    """Exchange both impulses at once and return the motions after."""
    push = normal_impulse(touch, held, bodies)
    impulse = push[:, None] * (touch.normal - ratio[:, None] * slip_direction(touch, bodies))
    both = impulse[:, None] * np.array([-1.0, 1.0])[:, None]
    velocity = touch.velocity + both / bodies.mass[:, None]
    # Lever and impulse change sign together, so that both spheres are turned alike.
    turn = -bodies.radius_m * np.cross(touch.normal, impulse)
    spin = touch.spin + turn[:, None] / bodies.inertia[:, None]
    return velocity, spin


def twist(nature: Nature, touch: Touch, held: Coefficients, spin: Floats, bodies: Bodies) -> Floats:
    """Return the spins (S, 2, 3) after a contact spot has resisted turning about the normal.

    A Hertz pressure of radius a that slips in rotation resists with the moment
    (3 pi / 16) mu a F; a grows with speed as Hertz's does. It stops the relative spin at most.
    """
    push = normal_impulse(touch, held, bodies)
    radius = nature.torsion_radius_m * (touch.approach / REFERENCE_SPEED_M_PER_S) ** 0.4
    moment = 3.0 * np.pi / 16.0 * held.friction * radius * push
    relative = np.einsum("si,si->s", spin[:, 1] - spin[:, 0], touch.normal)
    stopping = np.abs(relative) / float((1.0 / bodies.inertia).sum())
    given = np.sign(relative) * np.minimum(moment, stopping)
    both = (given[:, None] * touch.normal)[:, None] * np.array([1.0, -1.0])[:, None]
    return np.asarray(spin + both / bodies.inertia[:, None])


def slip_direction(touch: Touch, bodies: Bodies) -> Floats:
    """Return the unit vector (S, 3) of the slip, zero where there is none."""
    slip = touch.slip(bodies.radius_m)
    length = np.linalg.norm(slip, axis=1, keepdims=True)
    return np.asarray(np.divide(slip, length, out=np.zeros_like(slip), where=length > 0.0))
