"""What a camera without a mirror does not see: what spins show of depth, and what may be besides.

Without the mirror Z is taken as constant (thesis, section 3.3). The true spheres lie off each
other in depth and drift in it, which turns the normal and the surface velocity out of the picture,
and friction pushes them out of it. Spins are seen whole, and their change shows all three: the
moment of the impulse gives what friction does in depth, it stands across the normal, which gives
the normal's tilt, and across the surface velocity that friction opposes, which gives the drift.
What is left enters the numbers partly by its square, so that no derivative shows it: whole impacts
with drawn depths are worked out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.contact_frames import DURATIONS_AFTER, longest_contact
from analysis.collision.derivative import derivative
from analysis.collision.instant import NoTouchError, touching_time
from analysis.collision.operator import Body

PLACE_SIGMA, SLOPE_SIGMA = 0.015, 0.005
"""Assumed of what sends a sphere: standard deviations of its depth at the contact in diameters, and
of its velocity in depth over its speed. A tube that points to 5 mrad and lies three diameters away
gives as much."""
FRICTION_SIGMA = 0.05
"""Assumed where no spin is known: standard deviation of friction in depth over the normal impulse.
"""
MOST_OFF = 4.0
"""Standard errors beyond which depth that spins show is none: one of them is wrong."""
TURN_SHARE, TURN_SIGMA = 0.25, 1e-3
"""Standard errors of the normal at the middle of the contact, as a share of its turn since first
touch (all of it where paths tell no duration), and of the direction of friction against the surface
velocity there, rad."""
DRAWS = 250
"""Depths that are drawn, each of them to either side."""
PLACES, DRIFTS, PUSHED = [2, 8], [5, 11], [17, 23]
"""Where a state holds depths of a and b, velocities in depth before and after contact."""
NORMAL, V_N, STATES, DURATION = slice(1, 4), 4, slice(10, 34), 34
"""Where these stand among the outcomes; states are velocities and spins of a and b."""

Outcomes = Callable[[Floats], Floats]
"""From states, shape (n, 37), to numbers, shape (n, 35), as in `coefficients.measure_impact`."""


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

    def scatter(self, numbers: Floats) -> Floats:
        """Return the covariance of depth among the states, as launches scatter it, shape (37, 37).

        Parameters
        ----------
        numbers
            Outcomes of the pair without depth, shape (35,).
        """
        masses = np.array([body.mass for body in self.bodies])
        diameters = 2.0 * np.array([body.radius for body in self.bodies])
        speeds = np.linalg.norm(numbers[10:16].reshape(2, 3), axis=1)
        covariance = np.zeros((37, 37))
        covariance[PLACES, PLACES] = (PLACE_SIGMA * diameters) ** 2
        covariance[DRIFTS, DRIFTS] = (SLOPE_SIGMA * speeds) ** 2
        if not self.spins_known.any():
            impulse = (numbers[6] - numbers[4]) / (1.0 / masses).sum()
            pushed = FRICTION_SIGMA * impulse / (masses * [-1.0, 1.0])
            covariance[np.ix_(PUSHED, PUSHED)] = np.outer(pushed, pushed)
        return covariance

    def shown(
        self, outcomes: Outcomes, centre: Floats, covariance: Floats, common: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Return state, covariance and shared errors by what the spins show of depth.

        A shot that just grazes, and would not touch in the depth that they show, has all three as
        they came.

        Parameters
        ----------
        outcomes
            From states to numbers.
        centre, covariance
            State without depth, and its covariance with what depth may be, shapes (37,), (37, 37).
        common
            What one standard error of each thing that all shots share does to the state, shape
            (K, 37): depth is found by what they have changed, and takes a part of it.

        Notes
        -----
        Forces at the contact change what both spheres turn with by -(R_a + R_b) n x J, whatever
        moments of its own the contact has: those on a and b are opposite. So the sum of both
        changes, I_a (w_a' - w_a) + I_b (w_b' - w_b), stands across the normal; and across the
        surface velocity, as nothing but that tells friction of like directions where to push. A
        step of a Kalman filter holds it to either, the normal taken at the middle of the contact.
        """
        came = centre, covariance, common
        if not self.spins_known.all():
            return came
        try:
            for which in (0, 1):
                numbers = outcomes(centre[None])
                turn = self._turn(numbers[0])
                share = TURN_SHARE if np.isfinite(numbers[0, DURATION]) else 1.0

                def off(states: Floats, turn: Floats = turn, which: int = which) -> Floats:
                    return self._across(outcomes(states), turn)[:, which : which + 1]

                as_turned, at_touch = (self._across(numbers, t)[0] for t in (turn, 0.0 * turn))
                value = float(as_turned[which])
                slope = derivative(off, centre, np.sqrt(np.diag(covariance)))[0]
                by_turn = share * (value - at_touch[which])
                by_law = TURN_SIGMA * as_turned[2] if which else 0.0
                along = covariance @ slope
                variance = float(slope @ along) + by_turn**2 + by_law**2
                if variance > 0.0 and value**2 <= MOST_OFF**2 * variance:
                    centre = centre - along * (value / variance)
                    covariance = covariance - np.outer(along, along) / variance
                    common = common - np.outer(common @ slope, along / variance)
            # What is worked out from here must touch, a tenth of its errors to either side too.
            derivative(outcomes, centre, np.sqrt(np.diag(covariance)))
        except NoTouchError:
            return came
        return centre, covariance, common

    def _turn(self, numbers: Floats) -> Floats:
        """Return what the normal has changed by at the middle of the contact, shape (3,)."""
        normal = numbers[NORMAL]
        relative = numbers[13:16] - numbers[10:13]
        longest = DURATIONS_AFTER * float(longest_contact(-numbers[V_N], self.bodies))
        lasts = np.clip(np.nan_to_num(numbers[DURATION], nan=longest), 0.0, longest)
        reach = self.bodies[0].radius + self.bodies[1].radius
        return np.asarray(0.5 * lasts / reach * (relative - (relative @ normal) * normal))

    def _across(self, numbers: Floats, turn: Floats) -> Floats:
        """Return what the spheres turn more with along the normal and the surface velocity.

        And the product of this change and the surface velocity, shape (n, 3).

        Parameters
        ----------
        numbers
            Outcomes, shape (n, 35).
        turn
            Of the normal since first touch, shape (3,).
        """
        before, after = numbers[:, STATES].reshape(-1, 2, 4, 3).swapaxes(0, 1)
        inertia = np.array([body.inertia for body in self.bodies])
        radii = np.array([body.radius for body in self.bodies])
        turned = np.einsum("i,nij->nj", inertia, after[:, 2:] - before[:, 2:])
        normal = numbers[:, NORMAL] + turn
        normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
        slip = before[:, 1] - before[:, 0]
        slip = slip - (slip * normal).sum(axis=1, keepdims=True) * normal
        slip = slip + np.cross(normal, np.einsum("i,nij->nj", radii, before[:, 2:]))
        both = np.linalg.norm(turned, axis=1) * np.linalg.norm(slip, axis=1)
        return np.stack([(turned * normal).sum(axis=1), (turned * slip).sum(axis=1), both], axis=1)

    def bend(
        self, outcomes: Outcomes, centre: Floats, covariance: Floats, jacobian: Floats
    ) -> Floats:
        """Return mean squares and products of what depth changes beyond its derivatives.

        Parameters
        ----------
        outcomes, jacobian
            From states to numbers, and its derivatives at `centre`, shape (35, 37).
        centre, covariance
            State and its covariance, shapes (37,) and (37, 37).

        Returns
        -------
        Shape (35, 35); not a number where no drawn pair touches.
        """
        free = PLACES + DRIFTS + PUSHED
        sizes, axes = np.linalg.eigh(covariance[np.ix_(free, free)])
        drawn = np.random.default_rng(0).standard_normal((DRAWS, len(free)))
        drawn = (drawn * np.sqrt(np.clip(sizes, 0.0, None))) @ axes.T
        moved = np.zeros((2 * DRAWS, len(centre)))
        moved[:, free] = np.concatenate([drawn, -drawn])
        states = centre + moved
        paths = states[:, :24].reshape(-1, 4, 2, 3)
        between = paths[:, 1] - paths[:, 0]
        reach = np.array(self.bodies[0].radius + self.bodies[1].radius)
        touch = ~np.isnan(touching_time(between[:, 0], between[:, 1], reach))
        if not touch.any():
            return np.full((len(jacobian),) * 2, np.nan)
        change = outcomes(states[touch]) - outcomes(centre[None]) - moved[touch] @ jacobian.T
        change = np.nan_to_num(change)
        return np.asarray(change.T @ change / touch.sum())
