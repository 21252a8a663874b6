"""Angular velocity of a sphere on one side of the collision (thesis, section 5.2.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.birge import variance_ratio
from analysis.cholesky import factor, solve
from analysis.compiled import compiled, part
from analysis.motion.drift import Drift
from analysis.motion.rotation import rotation_vector
from analysis.motion.turning import turn_between, turn_slopes, turned

ITERATIONS, SETTLED_RAD = 8, 1e-10
HUBER_LIMIT = 3.0
MOST_LASTING = 3.0
"""What lasts in the residuals, squared, may be this many times what the slow error leaves in them:
of a flight of few correlation times it scatters by as much."""
CHANCE_SIGMAS = 3.0
"""Standard deviations of what fresh errors have in common by chance."""
FARTHEST = 6.0
"""Errors of an orientation beyond which it lies no further off, when what lasts is looked for."""


@dataclass(frozen=True, slots=True, eq=False)
class Spin:
    """Angular velocity with its covariance.

    Attributes
    ----------
    velocity
        rad/s in rig axes, shape (3,).
    covariance
        (rad/s)^2, shape (3, 3).
    chi2_per_dof
        Of the fit. Not a number without freedom.
    """

    velocity: Floats
    covariance: Floats
    chi2_per_dof: float


def fit_spin(times_s: Floats, rotations: Floats, covariances: Floats, drift: Drift) -> Spin:
    """Fit a constant angular velocity to the orientations of one side.

    Gauss-Newton for R(t) = exp([w] (t - t0)) exp([d]) R0, residuals being rotation vectors of
    R_observed R_predicted', whitened, with Huber weights. A small turn d is seen turned with the
    sphere, so that slopes change along a flight (`turning.turn_slopes`). A free sphere has no
    torque on it but that of the air, which is negligible here. The covariance is enlarged where the
    residuals contradict their stated errors (`birge.variance_ratio`), and its slow part where what
    neighbouring residuals have in common is far more than the slow error leaves in them: a marker
    in a wrong place wanders through all frames that show it.

    Parameters
    ----------
    times_s
        Shape (frames,), at least 2.
    rotations
        Body to rig axes, shape (frames, 3, 3).
    covariances
        Of small rotation vectors in rig axes, rad^2, shape (frames, 3, 3).
    drift
        Slow error of the orientation about each axis, rad.
    """
    tau = times_s - times_s.mean()
    roots = np.linalg.cholesky(np.linalg.inv(covariances))
    whiten = np.ascontiguousarray(roots.transpose(0, 2, 1))
    middle = int(np.abs(tau).argmin())
    start = rotations[middle]
    steps = rotation_vector(rotations[1:] @ rotations[:-1].transpose(0, 2, 1))
    omega = np.median(steps / np.diff(times_s)[:, None], axis=0)
    start = turned(-omega * tau[middle], start)
    inverse, squares, weight = settle_spin((tau, rotations, whiten), start, omega)
    slopes = np.array([turn_slopes(omega, time) for time in tau])
    jacobian = whiten @ slopes
    across = jacobian.transpose(0, 2, 1)
    freedom = 3 * len(tau) - 6
    chi2 = float(squares.sum() / freedom) if freedom else float("nan")
    gain = inverse @ (weight[:, None, None] * across) @ whiten
    passed_on = np.tensordot(drift.covariance(times_s), gain, 1)
    slow = np.tensordot(gain, passed_on, ((0, 2), (0, 2)))
    fresh = inverse * variance_ratio(squares.sum(), freedom)
    predicted = np.array([turned(omega * time, start) for time in tau])
    residuals = rotation_vector(rotations @ predicted.transpose(0, 2, 1))
    left = drift.between_neighbours(times_s), passed_on, slow
    lasting = _lasting(residuals, (slopes, whiten), (left, inverse))
    return Spin(omega, (fresh + lasting * slow)[3:, 3:], chi2)


def _lasting(
    residuals: Floats,
    seen: tuple[Floats, Floats],
    left: tuple[tuple[Floats, Floats, Floats], Floats],
) -> float:
    """Return by how much the variance of the slow error is enlarged: 1 where it explains the rest.

    Fresh errors of neighbouring frames have nothing in common but what the fit has made of them, so
    that the sum of the products of neighbouring residuals is that of the slow error, by chance off
    by the square root of their number.

    Parameters
    ----------
    residuals
        Rotation vectors, rad, shape (frames, 3).
    seen
        Derivatives of orientations to what is fitted, shape (frames, 3, 6), and what whitens their
        errors, shape (frames, 3, 3).
    left
        Covariance of the slow error between each frame and the next, shape (frames - 1,), of it
        and of what is fitted, shape (frames, 6, 3), and of what is fitted by it, shape (6, 6); and
        the covariance of what is fitted by fresh errors, shape (6, 6).
    """
    slopes, whiten = seen
    (between, passed_on, slow), inverse = left
    if not between.any():
        return 1.0
    white = (whiten @ residuals[..., None])[..., 0]
    # A frame or two in a wrong turn are no slow error.
    white *= np.minimum(1.0, FARTHEST / np.maximum(np.linalg.norm(white, axis=1), 1.0))[:, None]
    common = float((white[1:] * white[:-1]).sum())
    here, ahead = slopes[:-1], slopes[1:].transpose(0, 2, 1)
    kept = between[:, None, None] * np.eye(3) - here @ passed_on[1:]
    kept = kept - passed_on[:-1].transpose(0, 2, 1) @ ahead + here @ slow @ ahead
    expected, of_fresh = (
        float(((whiten[:-1] @ own) * whiten[1:]).sum()) for own in (kept, -here @ inverse @ ahead)
    )
    by_chance = CHANCE_SIGMAS * math.sqrt(residuals[1:].size)
    beyond = common - of_fresh - by_chance
    return beyond / expected if beyond > MOST_LASTING * expected > 0.0 else 1.0


@compiled
def settle_spin(
    seen: tuple[Floats, Floats, Floats], start: Floats, omega: Floats
) -> tuple[Floats, Floats, Floats]:
    """Improve orientation and angular velocity in place, as `fit_spin` describes.

    Parameters
    ----------
    seen
        Times about their mean, s, rotations, and what whitens their errors, shapes (frames,),
        (frames, 3, 3) and (frames, 3, 3).
    start, omega
        Orientation at the mean time and rad/s, shapes (3, 3) and (3,).

    Returns
    -------
    Inverse of the normal equations of both, shape (6, 6); squares of the whitened residuals and
    weights, shape (frames,).
    """
    tau, rotations, whiten = seen
    inverse, squares, weight = np.zeros((6, 6)), np.zeros(tau.size), np.ones(tau.size)
    step, turn = np.empty(6), np.empty(3)
    for _ in range(ITERATIONS):
        normal, right = np.zeros((6, 6)), np.zeros(6)
        longest = 0.0
        for n in range(tau.size):
            longest = max(longest, abs(tau[n]))
            for a in range(3):
                turn[a] = omega[a] * tau[n]
            residual = turn_between(turned(turn, start), rotations[n])
            white = np.zeros(3)
            for a in range(3):
                for b in range(3):
                    white[a] += whiten[n, a, b] * residual[b]
            squares[n] = white[0] ** 2 + white[1] ** 2 + white[2] ** 2
            weight[n] = min(1.0, HUBER_LIMIT / math.sqrt(max(squares[n], 1e-12)))
            slopes = turn_slopes(omega, tau[n])
            for a in range(3):
                row = np.zeros(6)
                for p in range(6):
                    for b in range(3):
                        row[p] += whiten[n, a, b] * slopes[b, p]
                for p in range(6):
                    right[p] += weight[n] * row[p] * white[a]
                    for q in range(p + 1):
                        normal[p, q] += weight[n] * row[p] * row[q]
        if not factor(normal, 6):
            break
        solve_for(normal, right, inverse, step)
        if take_step(step, start, omega, longest) < SETTLED_RAD:
            break
    return inverse, squares, weight


@part
def solve_for(root: Floats, right: Floats, inverse: Floats, step: Floats) -> None:
    """Fill the inverse of what `factor` has prepared, and its product with the right side."""
    for a in range(6):
        step[a] = 0.0
        for b in range(6):
            inverse[a, b] = 1.0 if a == b else 0.0
        solve(root, 6, inverse[a])
        for b in range(6):
            step[a] += inverse[a, b] * right[b]


@part
def take_step(step: Floats, start: Floats, omega: Floats, longest: float) -> float:
    """Turn the orientation and add to the angular velocity; return the most that a frame turns.

    Parameters
    ----------
    step
        rad and rad/s, shape (6,).
    longest
        Time of the furthest frame, s.
    """
    now, later, changed = 0.0, 0.0, turned(step[:3], start)
    for a in range(3):
        omega[a] += step[3 + a]
        now, later = max(now, abs(step[a])), max(later, abs(step[3 + a]))
        for b in range(3):
            start[a, b] = changed[a, b]
    return now + later * longest


def three_frame_spin(
    times_s: Floats, rotations: Floats, covariances: Floats, drift: Drift, nearest: int
) -> Spin:
    """Return the angular velocity at the frame nearest the collision, equations (5-32), (5-33).

    Parameters
    ----------
    times_s, rotations, covariances
        Three frames in the order of time, shapes (3,), (3, 3, 3), (3, 3, 3).
    drift
        Slow error of the orientation about each axis, rad.
    nearest
        Index of the frame nearest the collision, 0 or -1.
    """
    first, second = np.diff(times_s)
    turn_1, turn_2 = rotation_vector(rotations[1:] @ rotations[:-1].transpose(0, 2, 1))
    total = first * second * (first + second)
    if nearest == 0:
        on_1, on_2 = second * (2 * first + second) / total, -(first**2) / total
    else:
        on_1, on_2 = -(second**2) / total, first * (2 * second + first) / total
    shares = np.array([-on_1, on_1 - on_2, on_2])
    fresh = np.einsum("n,nij->ij", shares**2, covariances)
    slow = float(shares @ drift.covariance(times_s) @ shares) * np.eye(3)
    return Spin(on_1 * turn_1 + on_2 * turn_2, fresh + slow, float("nan"))
