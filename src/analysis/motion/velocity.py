"""Velocity of a sphere's centre on one side of the collision (thesis, section 5.1)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import leggauss

from analysis.arrays import Floats
from analysis.birge import variance_ratio
from analysis.cholesky import factor, gram, solve
from analysis.compiled import compiled
from analysis.motion.drift import Drift


@compiled
def fit_axes(
    tau: Floats, values: Floats, beside: Floats, sigmas: Floats, slow: Floats
) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Fit a straight line to each coordinate, where it was measured.

    Parameters
    ----------
    tau
        Shape (frames,).
    values, beside
        Coordinates, and what else a line is drawn through with the same errors, shape (frames, 3).
    sigmas
        Standard errors of the coordinates, infinite where not measured, shape (frames, 3).
    slow
        Covariance of what lasts, the same of each coordinate, shape (frames, frames).

    Returns
    -------
    Values at 0 and slopes, shape (2, 3); the same of what is beside them; the covariances, shape
    (3, 2, 2); products of what is left of both, over the errors, shape (3, 2, 2); and the number of
    frames, shape (3,).
    """
    state, other, inverse = np.zeros((2, 3)), np.zeros((2, 3)), np.zeros((3, 2, 2))
    left, seen = np.zeros((3, 2, 2)), np.zeros(3)
    used = np.zeros(tau.size, dtype=np.int64)
    for axis in range(3):
        count = 0
        for k in range(tau.size):
            if math.isfinite(sigmas[k, axis]):
                used[count] = k
                count += 1
        times, rows, spread = np.zeros(count), np.zeros((2, count)), np.zeros((count, count))
        for a in range(count):
            k = used[a]
            times[a], rows[0, a], rows[1, a] = tau[k], values[k, axis], beside[k, axis]
            for b in range(a + 1):
                spread[a, b] = slow[k, used[b]]
            spread[a, a] += sigmas[k, axis] ** 2
        lines, inverse[axis], left[axis] = fit_lines(times, rows, spread)
        for k in range(2):
            state[k, axis], other[k, axis] = lines[0, k], lines[1, k]
        seen[axis] = count
    return state, other, inverse, left, seen


@compiled
def fit_lines(tau: Floats, values: Floats, spread: Floats) -> tuple[Floats, Floats, Floats]:
    """Fit a straight line through each of some rows of values with the same correlated errors.

    Parameters
    ----------
    tau, values
        Shapes (points,), at least 2, and (rows, points).
    spread
        Covariance of the values, shape (points, points); its lower triangle is used up.

    Returns
    -------
    Values at 0 and slopes, shape (rows, 2); their covariance, shape (2, 2); sums of products of
    what is left of each two rows, over the errors, shape (rows, rows): chi-squared on the diagonal.

    Raises
    ------
    ValueError
        The covariance is not positive definite, or all points have one time.
    """
    count, rows = tau.size, values.shape[0]
    if not factor(spread, count):
        raise ValueError("the errors of a track must be positive and no two of them the same one")
    # Each column over the errors' root: constant, time and values.
    white, products = np.ones((2 + rows, count)), np.zeros((2 + rows, 2 + rows))
    white[1], white[2:] = tau, values
    for column in white:
        for a in range(count):
            left = column[a]
            for k in range(a):
                left -= spread[a, k] * column[k]
            column[a] = left / spread[a, a]
    gram(white, np.ones(count), products)
    normal, lines, inverse = products[:2, :2].copy(), products[2:, :2].copy(), np.eye(2)
    if not factor(normal, 2):
        raise ValueError("a line through one time has no slope: give two frames at least")
    for k in range(2):
        solve(normal, 2, inverse[k])
    left = np.zeros((rows, rows))
    for n in range(rows):
        solve(normal, 2, lines[n])
        white[2 + n] -= lines[n, 0] * white[0] + lines[n, 1] * white[1]
        for m in range(n + 1):
            left[n, m] = left[m, n] = np.sum(white[2 + n] * white[2 + m])
    return lines, inverse, left


DOWN = np.array([1.0, 0.0, 0.0])
"""Gravity acts along +X."""


@dataclass(frozen=True, slots=True)
class Drag:
    """Deceleration by the air over the square of the speed, 1/m: corrected value and its error."""

    per_m: float = 0.0
    sigma_per_m: float = 0.0


NO_DRAG = Drag()
NODES = tuple(0.5 * (part + shift) for part, shift in zip(leggauss(4), (1.0, 0.0), strict=True))
"""Places and weights of an integral from 0 to 1 by four points (Gauss and Legendre)."""


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
        Of the fit, less what an error of the drag explains; 1 where the stated errors are right.
        Not a number without freedom.
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
    """Fit X = X0 + V tau + g tau^2 / 2 + k D(tau) to all frames of one side.

    D is what the air slows by, -|v| v with v = V + g tau, twice integrated: in the twenty frames of
    a film at 250/s a falling sphere nearly doubles its speed, and a drag as at the contact would be
    off by a third. Gravity is known, and the drag k as far as it is stated; leaving the
    acceleration free costs a factor of 3.6 in the error of the velocity for nothing, since drag
    changes it by less than 2 mm/s in 6 ms. The shift of the fit by the error of k is
    `FlightPath.drag_shift`. A coordinate whose residuals contradict its stated errors has its
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
    fall = gravity * DOWN
    straight = positions - 0.5 * fall * tau[:, None] ** 2
    sigmas, lasting = np.ascontiguousarray(sigmas), drift.covariance(times_s)
    slowed = np.zeros_like(straight)
    state, bend, inverse, left, seen = fit_axes(tau, straight, slowed, sigmas, lasting)
    if drag.per_m > 0.0 or drag.sigma_per_m > 0.0:
        slowed = slowed_by_drag(tau, state[1], fall)
        other = straight - drag.per_m * slowed
        state, bend, inverse, left, seen = fit_axes(tau, other, slowed, sigmas, lasting)
    chi2, freedom = _unexplained(left, drag.sigma_per_m), seen - 2
    enlarged = inverse * variance_ratio(chi2, freedom)[:, None, None]
    covariance = np.zeros((2, 3, 2, 3))
    for axis in range(3):
        covariance[:, axis, :, axis] = enlarged[axis]
    return FlightPath(
        reference_s=reference_s,
        position=state[0],
        velocity=state[1],
        acceleration=fall - drag.per_m * np.linalg.norm(state[1]) * state[1],
        covariance=covariance.reshape(6, 6),
        chi2_per_dof=float(chi2.sum() / freedom.sum()) if freedom.any() else float("nan"),
        drag_shift=(drag.sigma_per_m * bend).ravel(),
    )


def _unexplained(left: Floats, sigma_per_m: float) -> Floats:
    """Return the chi-squared of each coordinate, shape (3,), less what an error of the drag makes.

    Parameters
    ----------
    left
        Products of what lines leave of the coordinates and of a drag of 1, shape (3, 2, 2).
    """
    both, own = left[:, 0, 1], left[:, 1, 1]
    more = sigma_per_m**2 * both.sum() / (1.0 + sigma_per_m**2 * own.sum())
    return np.asarray(left[:, 0, 0] - 2.0 * more * both + more**2 * own)


def slowed_by_drag(tau: Floats, velocity: Floats, fall: Floats) -> Floats:
    """Return -|v| v twice integrated from 0 to each time, v = velocity + fall tau, shape (n, 3)."""
    share, weight = NODES
    flown = velocity + fall * (tau[:, None] * share)[..., None]
    slowing = np.linalg.norm(flown, axis=-1, keepdims=True) * flown
    twice = tau[:, None] ** 2 * (1.0 - share) * weight
    return np.asarray(-np.einsum("ka,kai->ki", twice, slowing))


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
