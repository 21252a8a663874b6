"""Rotations one at a time inside compiled functions; `rotation` has them in arrays."""

from __future__ import annotations

import math

import numpy as np

from analysis.arrays import Floats
from analysis.compiled import compiled


@compiled
def turned(vector: Floats, rotation: Floats) -> Floats:
    """Return exp([vector]) rotation, the vector in radians, shape (3, 3)."""
    x, y, z = vector[0], vector[1], vector[2]
    angle = math.sqrt(x * x + y * y + z * z)
    one = math.sin(angle) / angle if angle > 1e-9 else 1.0
    two = (1 - math.cos(angle)) / angle**2 if angle > 1e-5 else 0.5
    result = np.empty((3, 3))
    for k in range(3):
        a, b, c = rotation[0, k], rotation[1, k], rotation[2, k]
        p, q, r = y * c - z * b, z * a - x * c, x * b - y * a
        result[0, k] = a + one * p + two * (y * r - z * q)
        result[1, k] = b + one * q + two * (z * p - x * r)
        result[2, k] = c + one * r + two * (x * q - y * p)
    return result


@compiled
def turn_slopes(spin: Floats, time_s: float) -> Floats:
    """Return how an orientation turns with its start's small turn and with its spin, shape (3, 6).

    Of exp([spin] time) exp([d]) R0 as a small rotation vector in rig axes: by d, rad, in the first
    three columns, by the spin, rad/s, in the others (left Jacobian of the exponential map,
    G. S. Chirikjian, Stochastic Models, Information Theory, and Lie Groups 2 (2012), section 10.8).

    Parameters
    ----------
    spin
        rad/s, shape (3,).
    """
    turn = spin * time_s
    square = turn[0] ** 2 + turn[1] ** 2 + turn[2] ** 2
    angle = math.sqrt(square)
    two, three = 0.5 - square / 24, 1 / 6 - square / 120
    if angle > 1e-3:
        two = (1 - math.cos(angle)) / square
        three = (angle - math.sin(angle)) / (angle * square)
    slopes = np.zeros((3, 6))
    slopes[:, :3] = turned(turn, np.eye(3))
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        for k in range(3):
            slopes[a, 3 + k] = time_s * three * turn[a] * turn[k]
        slopes[a, 3 + a] += time_s * (1 - three * square)
        slopes[a, 3 + b] -= time_s * two * turn[c]
        slopes[a, 3 + c] += time_s * two * turn[b]
    return slopes


@compiled
def turn_between(first: Floats, second: Floats) -> Floats:
    """Return axis times angle, radians, of the turn that takes one rotation to another, shape (3,).

    By the quaternion of the turn, taken from its largest component (S. W. Shepperd, J. Guidance
    and Control 1, 223-224 (1978), doi:10.2514/3.55767b): sound at every angle.
    """
    turn = np.zeros((3, 3))
    for a in range(3):
        for b in range(3):
            for k in range(3):
                turn[a, b] += second[a, k] * first[b, k]
    trace, largest = turn[0, 0] + turn[1, 1] + turn[2, 2], 0
    for k in range(1, 3):
        if turn[k, k] > turn[largest, largest]:
            largest = k
    i, j = (largest + 1) % 3, (largest + 2) % 3
    quarter = np.zeros(3)
    if trace > turn[largest, largest]:
        scalar = 1.0 + trace
        for k in range(3):
            quarter[k] = turn[(k + 2) % 3, (k + 1) % 3] - turn[(k + 1) % 3, (k + 2) % 3]
    else:
        scalar = turn[j, i] - turn[i, j]
        quarter[largest] = 1.0 + turn[largest, largest] - turn[i, i] - turn[j, j]
        quarter[i] = turn[i, largest] + turn[largest, i]
        quarter[j] = turn[j, largest] + turn[largest, j]
    sine = math.sqrt(quarter[0] ** 2 + quarter[1] ** 2 + quarter[2] ** 2)
    if sine == 0.0:
        return quarter
    if scalar < 0.0:
        scalar, sine = -scalar, -sine
    return quarter * (2.0 * math.atan2(abs(sine), scalar) / sine)
