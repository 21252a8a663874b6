"""Derivatives of the 48 numbers of both flights, by an outcome of contact and by a shot's state.

The 48: two spheres, then position and orientation, then before and after, then start and rate in
three axes. An outcome has 25 numbers: velocities and spins after (12), duration, shifts of both
centres (6), turns of both spheres (6).
"""

from __future__ import annotations

import math

import numpy as np

from analysis.arrays import Floats
from analysis.compiled import compiled
from analysis.model.loops.flight import exponential_at

LATE, SHIFT, TURN = 12, 13, 19
POINT, TILT, MOTION, TURNS = 1, 4, 6, 18
"""Where these begin among the numbers of an outcome, and of a state."""
AFTER, RATE, ORIENTATION, SPHERE = 6, 3, 12, 24
"""How far apart sides, start and rate, kinds and spheres stand among the 48."""


@compiled
def tangents(normal: Floats) -> tuple[Floats, Floats]:
    """Return two unit vectors across each normal (S, 3) and each other, both of shape (S, 3)."""
    first, second = np.zeros(normal.shape), np.empty(normal.shape)
    for s in range(normal.shape[0]):
        own, across, other = normal[s], first[s], second[s]
        least = 0
        for k in range(1, 3):
            if abs(own[k]) < abs(own[least]):
                least = k
        i, j = (least + 1) % 3, (least + 2) % 3
        size = math.sqrt(own[i] ** 2 + own[j] ** 2)
        across[i], across[j] = own[j] / size, -own[i] / size
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            other[k] = own[i] * across[j] - own[j] * across[i]
    return first, second


@compiled
def by_outcome(outcome: Floats, change: Floats) -> Floats:
    """Return what changes of an outcome (S, 25, K) do to the 48 numbers, shape (S, 48, K)."""
    shots, _, count = change.shape
    result = np.zeros((shots, 48, count))
    back, jacobian, spare = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    for s in range(shots):
        duration, own = outcome[s, LATE], change[s]
        for i in range(2):
            velocity, spin = 3 * i, 6 + 3 * i
            exponential_at(outcome[s, spin : spin + 3], -duration, back, spare)
            turn = TURN + 3 * i
            exponential_at(outcome[s, turn : turn + 3], 1.0, spare, jacobian)
            first = SPHERE * i + AFTER
            for a in range(3):
                place, turned = result[s, first + a], result[s, first + ORIENTATION + a]
                moving = result[s, first + RATE + a]
                turning = result[s, first + ORIENTATION + RATE + a]
                for k in range(count):
                    late = own[LATE, k]
                    moving[k], turning[k] = own[velocity + a, k], own[spin + a, k]
                    place[k] = own[SHIFT + 3 * i + a, k] - moving[k] * duration
                    place[k] -= outcome[s, velocity + a] * late
                    turned[k] = -turning[k] * duration - outcome[s, spin + a] * late
                for b in range(3):
                    share = 0.0
                    for c in range(3):
                        share += back[a, c] * jacobian[c, b]
                    for k in range(count):
                        turned[k] += share * own[turn + b, k]
    return result


@compiled
def add_own(
    whole: Floats,
    tangents: tuple[Floats, Floats],
    rates: tuple[Floats, Floats],
    turns: tuple[Floats, Floats],
    setting: tuple[float, float, float],
) -> None:
    """Add to derivatives by a state, (S, 48, 24), what does not come by way of the contact.

    Parameters
    ----------
    whole
        What does; changed in place.
    tangents
        Along which a normal is tilted, shape (S, 3).
    rates
        Velocities and spins, m/s and rad/s, before and after, shape (S, 2, 2, 3).
    turns
        Orientations at tau = 0 before and after, (S, 2, 2, 3, 3), and at first touch (S, 2, 3, 3).
    setting
        From the point of contact to the centres of a and of b along the normal, m, and gravity
        along +X, m/s^2.
    """
    for s in range(whole.shape[0]):
        for i in range(2):
            for side in range(2):
                place = SPHERE * i + AFTER * side
                turn = place + ORIENTATION
                for a in range(3):
                    whole[s, place + a, POINT + a] += 1.0
                    whole[s, place + a, TILT] += setting[i] * tangents[0][s, a]
                    whole[s, place + a, TILT + 1] += setting[i] * tangents[1][s, a]
                    whole[s, place + a, 0] -= rates[0][s, i, side, a]
                    whole[s, turn + a, 0] -= rates[1][s, i, side, a]
                    for b in range(3):
                        relative = 0.0
                        for c in range(3):
                            relative += turns[0][s, i, side, a, c] * turns[1][s, i, b, c]
                        whole[s, turn + a, TURNS + 3 * i + b] = relative
                whole[s, place + RATE, 0] -= setting[2]
            for a in range(3):
                start = SPHERE * i + RATE + a
                whole[s, start, MOTION + 3 * i + a] = 1.0
                whole[s, start + ORIENTATION, MOTION + 6 + 3 * i + a] = 1.0
