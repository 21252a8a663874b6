"""Velocity of a sphere's centre on one side of the collision (thesis, section 5.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.birge import variance_ratio
from analysis.motion.drift import Drift
from analysis.motion.lines import fit_axes

Floats = NDArray[np.float64]

DOWN = np.array([1.0, 0.0, 0.0])
"""Gravity acts along +X."""


@dataclass(frozen=True, slots=True)
class Drag:
    """Deceleration by the air over the square of the speed, 1/m: what is taken out, its error."""

    per_m: float = 0.0
    sigma_per_m: float = 0.0


NO_DRAG = Drag()


@dataclass(frozen=True, slots=True, eq=False)
class FlightPath:
    """Free flight about a reference time.

    Attributes
    ----------
    reference_s
        Time at which position and velocity hold, s from the shot's first frame.
    position, velocity
        m and m/s in rig axes, shape (3,).
    acceleration
        m/s^2, shape (3,): gravity and stated drag, or what three frames gave.
    covariance
        Of (position, velocity), shape (6, 6).
    chi2_per_dof
        Of the fit; 1 where the stated errors are right. Not a number without freedom.
    drag_shift
        By how much one standard error of the drag moves (position, velocity), shape (6,): an
        error that all paths of a shot have together.
    """

    reference_s: float
    position: Floats
    velocity: Floats
    acceleration: Floats
    covariance: Floats
    chi2_per_dof: float
    drag_shift: Floats

    def at(self, time_s: float) -> tuple[Floats, Floats]:
        """Return position and velocity at a time."""
        tau = time_s - self.reference_s
        velocity = self.velocity + self.acceleration * tau
        return self.position + (self.velocity + velocity) / 2 * tau, velocity

    def moved_to(self, time_s: float) -> FlightPath:
        """Return the same flight with another reference time."""
        tau = time_s - self.reference_s
        carry = np.eye(6)
        carry[:3, 3:] = tau * np.eye(3)
        position, velocity = self.at(time_s)
        return FlightPath(
            reference_s=time_s,
            position=position,
            velocity=velocity,
            acceleration=self.acceleration,
            covariance=carry @ self.covariance @ carry.T,
            chi2_per_dof=self.chi2_per_dof,
            drag_shift=carry @ self.drag_shift,
        )


def fit_flight(
    times_s: Floats,
    positions: Floats,
    sigmas: Floats,
    drift: Drift,
    *,
    gravity: float,
    reference_s: float,
    drag: Drag = NO_DRAG,
) -> FlightPath:
    """Fit X = X0 + V tau + (g - k |V| V) tau^2 / 2 to all frames of one side.

    Gravity is known, and the drag k of the air as far as it is stated; leaving the acceleration
    free costs a factor of 3.6 in the error of the velocity for nothing, since drag changes it by
    less than 2 mm/s in 6 ms. What the error of k does to the fit is told beside it
    (`FlightPath.drag_shift`). A coordinate whose residuals contradict its stated errors has its
    covariance enlarged by that much (`birge.variance_ratio`).

    Parameters
    ----------
    times_s
        Shape (frames,).
    positions, sigmas
        Centres and their standard errors, m, shape (frames, 3); a coordinate with an infinite
        sigma was not measured. At least 2 frames must hold each coordinate.
    drift
        Slow error of each coordinate, m.
    gravity
        m/s^2 along +X.
    reference_s
        Time at which the result holds.
    drag
        Of the air on this sphere.
    """
    tau = times_s - reference_s
    acceleration = gravity * DOWN
    sigmas, lasting = np.ascontiguousarray(sigmas), drift.covariance(times_s)

    def fitted() -> tuple[Floats, Floats, Floats, Floats, Floats]:
        straight = positions - 0.5 * acceleration * tau[:, None] ** 2
        return fit_axes(tau, straight, sigmas, lasting)

    state, bend, inverse, chi2, seen = fitted()
    if drag.per_m > 0.0:
        acceleration = acceleration - drag.per_m * np.linalg.norm(state[1]) * state[1]
        state, bend, inverse, chi2, seen = fitted()
    freedom = seen - 2
    enlarged = inverse * variance_ratio(chi2, freedom)[:, None, None]
    covariance = np.zeros((2, 3, 2, 3))
    for axis in range(3):
        covariance[:, axis, :, axis] = enlarged[axis]
    return FlightPath(
        reference_s=reference_s,
        position=state[0],
        velocity=state[1],
        acceleration=acceleration,
        covariance=covariance.reshape(6, 6),
        chi2_per_dof=float(chi2.sum() / freedom.sum()) if freedom.any() else float("nan"),
        drag_shift=(-drag.sigma_per_m * np.linalg.norm(state[1]) * state[1] * bend).ravel(),
    )


def three_frame_flight(
    times_s: Floats, positions: Floats, sigmas: Floats, drift: Drift, nearest: int
) -> FlightPath:
    """Return velocity and constant acceleration from three frames, equations (5-2) to (5-4).

    Parameters
    ----------
    times_s, positions, sigmas
        Three frames in the order of time, shapes (3,), (3, 3), (3, 3).
    drift
        Slow error of each coordinate, m.
    nearest
        Index of the frame nearest the collision, 0 or -1: position and velocity hold there.
    """
    tau = times_s - times_s[nearest]
    design = np.stack([np.ones(3), tau, 0.5 * tau**2], 1)
    inverse = np.linalg.inv(design)
    state = inverse @ positions
    covariance = np.zeros((6, 6))
    for axis in range(3):
        errors = np.diag(sigmas[:, axis] ** 2) + drift.covariance(times_s)
        full = inverse @ errors @ inverse.T
        covariance[np.ix_([axis, axis + 3], [axis, axis + 3])] = full[:2, :2]
    return FlightPath(
        reference_s=float(times_s[nearest]),
        position=state[0],
        velocity=state[1],
        acceleration=state[2],
        covariance=covariance,
        chi2_per_dof=float("nan"),
        drag_shift=np.zeros(6),
    )
