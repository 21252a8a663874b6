"""Restitution of viscoelastic spheres, from their equation of motion.

x'' = -x^(3/2) - gamma x^(1/2) x' in units of the elastic contact, from x' = 1 until the force
vanishes; gamma grows with the fifth root of the approach speed.

References
----------
Kuwabara, Kono, Jpn. J. Appl. Phys. 26 (1987) 1230-1233, doi:10.1143/JJAP.26.1230.
Ramirez, Poeschel, Brilliantov, Schwager, Phys. Rev. E 60 (1999) 4465-4472,
doi:10.1103/PhysRevE.60.4465.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

REFERENCE_SPEED_M_PER_S = 2.0
_LARGEST_GAMMA = 0.8
_LONGEST_CONTACT = 3.6
_STEPS = 1800


def restitution_of(gamma: Floats) -> Floats:
    """Integrate one contact for each gamma (N,) and return its restitution (N,)."""
    state = np.array([np.zeros_like(gamma), np.ones_like(gamma)])
    step = _LONGEST_CONTACT / _STEPS

    def rates(state: Floats) -> Floats:
        root = np.sqrt(np.maximum(state[0], 0.0))
        push = np.maximum(root * (state[0] + gamma * state[1]), 0.0)
        return np.array([state[1], -push])

    for _ in range(_STEPS):
        first = rates(state)
        second = rates(state + 0.5 * step * first)
        third = rates(state + 0.5 * step * second)
        fourth = rates(state + step * third)
        state = state + step / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
    return np.asarray(-state[1])


def softening(speed_m_per_s: Floats, restitution: float, share: float) -> Floats:
    """Return e at each speed (N,) over e at 2 m/s.

    `share` of 1 is the viscoelastic contact that has `restitution` at 2 m/s; less scales its
    viscosity.
    """
    gammas, table = _table()
    full = float(np.interp(-restitution, -table, gammas))
    gamma = share * full * (speed_m_per_s / REFERENCE_SPEED_M_PER_S) ** 0.2
    return np.asarray(np.interp(gamma, gammas, table) / np.interp(share * full, gammas, table))


@cache
def _table() -> tuple[Floats, Floats]:
    gammas = np.linspace(0.0, _LARGEST_GAMMA, 401)
    return gammas, restitution_of(gammas)
