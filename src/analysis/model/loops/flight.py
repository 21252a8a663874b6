"""Free flight of both spheres at the true times of all frames, pose by pose."""

from __future__ import annotations

import math

import numpy as np

from analysis.arrays import Floats
from analysis.compiled import compiled, part

SMALL_RAD = 1e-4
"""Below it the series of the exponential map are exact to double precision."""


@compiled
def free_flight(
    times: tuple[Floats, Floats],
    motion: tuple[Floats, Floats, Floats],
    touched: Floats,
    gravity: float,
) -> tuple[Floats, Floats, Floats, Floats, Floats, Floats]:
    """Follow x = start + velocity tau + g tau^2 / 2 and R = exp(spin tau) start.

    Parameters
    ----------
    times
        tau of each coordinate, s, shape (S, F, 2, 3), and of the orientation, (S, F, 2): before
        contact where it is not positive.
    motion
        Place (m), velocity (m/s) and spin (rad/s) of both spheres at tau = 0, before and after
        contact, each of shape (S, 2, 2, 3).
    touched
        Their orientations at tau = 0, shape (S, 2, 2, 3, 3).
    gravity
        m/s^2 along +X.

    Returns
    -------
    Position, velocity without gravity's part and spin, shape (S, F, 2, 3); orientation, left
    Jacobian of spin tau and exp(spin tau), shape (S, F, 2, 3, 3).
    """
    tau, tau_turn = times
    place, rate, turning = motion
    shots, frames = tau_turn.shape[0], tau_turn.shape[1]
    position = np.empty((shots, frames, 2, 3))
    velocity, spin = np.empty_like(position), np.empty_like(position)
    rotation = np.empty((shots, frames, 2, 3, 3))
    jacobian, turned = np.empty_like(rotation), np.empty_like(rotation)
    for s in range(shots):
        for f in range(frames):
            for i in range(2):
                for k in range(3):
                    t = tau[s, f, i, k]
                    side = 1 if t > 0 else 0
                    velocity[s, f, i, k] = rate[s, i, side, k]
                    position[s, f, i, k] = place[s, i, side, k] + rate[s, i, side, k] * t
                position[s, f, i, 0] += 0.5 * gravity * tau[s, f, i, 0] ** 2
                t = tau_turn[s, f, i]
                side = 1 if t > 0 else 0
                for k in range(3):
                    spin[s, f, i, k] = turning[s, i, side, k]
                whole, response = turned[s, f, i], jacobian[s, f, i]
                exponential_at(spin[s, f, i], t, whole, response)
                start, result = touched[s, i, side], rotation[s, f, i]
                for a in range(3):
                    for b in range(3):
                        result[a, b] = (
                            whole[a, 0] * start[0, b]
                            + whole[a, 1] * start[1, b]
                            + whole[a, 2] * start[2, b]
                        )
    return position, velocity, spin, rotation, jacobian, turned


@part
def exponential_at(rate: Floats, time: float, turned: Floats, jacobian: Floats) -> None:
    """Fill exp(v) and its left Jacobian of v = rate time, as `motion.exponential` has them."""
    x, y, z = rate[0] * time, rate[1] * time, rate[2] * time
    square = x * x + y * y + z * z
    angle = math.sqrt(square)
    if angle > SMALL_RAD:
        sine = math.sin(angle) / angle
        versine = (1 - math.cos(angle)) / square
        third = (1 - sine) / square
    else:
        sine, versine, third = 1 - square / 6, 0.5 - square / 24, 1 / 6 - square / 120
    _combine(x, y, z, (1 - versine * square, sine, versine), turned)
    _combine(x, y, z, (1 - third * square, versine, third), jacobian)


@part
def _combine(
    x: float, y: float, z: float, weights: tuple[float, float, float], matrix: Floats
) -> None:
    """Fill w0 1 + w1 [v]x + w2 v v'."""
    one, skew, outer = weights
    matrix[0, 0] = one + outer * x * x
    matrix[1, 1] = one + outer * y * y
    matrix[2, 2] = one + outer * z * z
    matrix[0, 1], matrix[1, 0] = outer * x * y - skew * z, outer * x * y + skew * z
    matrix[0, 2], matrix[2, 0] = outer * x * z + skew * y, outer * x * z - skew * y
    matrix[1, 2], matrix[2, 1] = outer * y * z - skew * x, outer * y * z + skew * x
