"""What a camera without a mirror does not see: by how much depth may change an impact's numbers.

Without the mirror Z is taken as constant (thesis, section 3.3). The true spheres lie off each
other in depth and drift in it, which turns the normal and the surface velocity out of the picture,
and friction pushes them out of it. Spins are seen whole: the moment of the impulse, which they
show, gives what friction does in depth. The rest enters the numbers mostly by its square, so that
no derivative shows it: whole impacts with depths drawn as tubes scatter them are worked out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.instant import touching_time
from analysis.collision.operator import Body

PLACE_SIGMA, SLOPE_SIGMA = 0.015, 0.005
"""Assumed of what sends a sphere: standard deviations of its depth at the contact in diameters, and
of its velocity in depth over its speed. A tube that points to 5 mrad and lies three diameters away
gives as much."""
FRICTION_SIGMA = 0.05
"""Assumed where no spin is known: standard deviation of friction in depth over the normal impulse.
"""
DRAWS = 500


@dataclass(frozen=True, slots=True, eq=False)
class UnseenDepth:
    """Depth of a pair that a camera without a mirror sees.

    Attributes
    ----------
    bodies
        Of a and b.
    spins_known
        Whether the spins of a and of b are known, before and after contact, shape (2,).
    """

    bodies: tuple[Body, Body]
    spins_known: NDArray[np.bool_]

    def after(self, velocity: Floats, spin: Floats, normal: Floats) -> Floats:
        """Return the velocities in depth of a and b after contact, m/s, shape (n, 2).

        Parameters
        ----------
        velocity, spin
            Of a and b before, of a and b after, m/s and rad/s, rig axes, shapes (n, 4, 3);
            velocities after contact hold in depth what friction does there beyond what spins show.
        normal
            Unit vectors from a to b, shape (n, 3).

        Notes
        -----
        The impulse J on b acts at R_a n from a and at -R_b n from b. Of either sphere
        I (w' - w) = -R n x J: the part of J across the normal is the mean of what both show. Along
        the normal it is what the change of velocity in the picture asks for.
        """
        a, b = self.bodies
        across = np.zeros(len(normal))
        for i in np.flatnonzero(self.spins_known):
            body = self.bodies[i]
            turned = (body.inertia / body.radius) * (spin[:, 2 + i] - spin[:, i])
            across += np.cross(normal, turned)[:, 2] / self.spins_known.sum()
        change = velocity[:, 3] - velocity[:, 2] - velocity[:, 1] + velocity[:, 0]
        in_picture = (change[:, :2] * normal[:, :2]).sum(axis=1) / (1.0 / a.mass + 1.0 / b.mass)
        depth = normal[:, 2]
        along = (in_picture + across * depth) / (1.0 - depth**2)
        pushed = (along * depth + across)[:, None] / np.array([-a.mass, b.mass])
        return np.asarray(velocity[:, :2, 2] + velocity[:, 2:, 2] + pushed)

    def spread(self, outcomes: Callable[[Floats], Floats], centre: Floats) -> Floats:
        """Return the mean squares and products of what unseen depth changes, shape (35, 35).

        Parameters
        ----------
        outcomes, centre
            As in `coefficients.measure_impact`: from states (n, 37) to numbers (n, 35).

        Returns
        -------
        Not a number where no drawn pair touches.
        """
        numbers = outcomes(centre[None])
        states = self._drawn(numbers[0], centre)
        paths = states[:, :24].reshape(-1, 4, 2, 3)
        between = paths[:, 1] - paths[:, 0]
        reach = np.array(self.bodies[0].radius + self.bodies[1].radius)
        touch = ~np.isnan(touching_time(between[:, 0], between[:, 1], reach))
        if not touch.any():
            return np.full((numbers.shape[1],) * 2, np.nan)
        change = np.nan_to_num(outcomes(states[touch]) - numbers)
        return np.asarray(change.T @ change / touch.sum())

    def _drawn(self, numbers: Floats, centre: Floats) -> Floats:
        """Return the state with drawn depths, shape (`DRAWS`, 37); the same draws each time."""
        rng = np.random.default_rng(0)
        masses = np.array([body.mass for body in self.bodies])
        diameters = 2.0 * np.array([body.radius for body in self.bodies])
        speeds = np.linalg.norm(numbers[10:16].reshape(2, 3), axis=1)
        places = rng.standard_normal((DRAWS, 2)) * PLACE_SIGMA * diameters
        drifts = rng.standard_normal((DRAWS, 2)) * SLOPE_SIGMA * speeds
        states = np.tile(centre, (DRAWS, 1))
        states[:, [2, 14]] = places[:, :1]
        states[:, [8, 20]] = places[:, 1:]
        states[:, [5, 11]] = drifts
        if not self.spins_known.any():
            impulse = (numbers[6] - numbers[4]) / (1.0 / masses).sum()
            friction = FRICTION_SIGMA * impulse * rng.standard_normal((DRAWS, 1))
            states[:, [17, 23]] = friction / (masses * [-1.0, 1.0])
        return states
