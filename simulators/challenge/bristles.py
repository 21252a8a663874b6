"""Tangential compliance: the two half-spaces as a row of elastic bristles under the Hertz load.

Reducing an axisymmetric contact to one dimension is exact for Hertz's normal and for
Cattaneo's and Mindlin's tangential contact, and so gives the impact of Maw, Barber and Fawcett.
Units: reduced mass, reduced radius, contact modulus and approach speed are 1.

References
----------
Maw, Barber, Fawcett, Wear 38 (1976) 101-114, doi:10.1016/0043-1648(76)90201-5.
Popov, Hess, Method of Dimensionality Reduction, Springer (2015), chapters 3 and 5,
doi:10.1007/978-3-642-53876-6.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulators.world.force import damping_ratio

Floats = NDArray[np.float64]

STIFFNESS_RATIO = 6.0 / 7.0
"""Tangential over normal modulus, 2 (1 - nu) / (2 - nu), for nu = 0.25 (thesis, table 7.1)."""

_BRISTLES = 80
_STEPS = 1000
_DEEPEST = (15.0 / 16.0) ** 0.4
_LONGEST = 1.15 * 2.94 * _DEEPEST


def impulse_ratio(slip: Floats, restitution: Floats, friction: Floats, mobility: float) -> Floats:
    """Return tangential over normal impulse for contacts that start with slip / approach (S,).

    The normal force is Hertz's with Tsuji's damping, so that e holds at every speed; bristle and
    limit of slip share its pressure. `mobility` is by how much more the surfaces yield to a
    tangential than to a normal impulse, 7/2 for solid spheres.
    """
    place = (np.arange(_BRISTLES) + 0.5) / _BRISTLES * np.sqrt(1.02 * _DEEPEST)
    spacing = place[1] - place[0]
    damping = np.array([damping_ratio(float(e)) for e in restitution]) * np.sqrt(20.0 / 3.0)
    depth, speed, sliding = np.zeros_like(slip), np.ones_like(slip), slip.copy()
    bent = np.zeros((len(slip), _BRISTLES))
    normal, tangential = np.zeros_like(slip), np.zeros_like(slip)
    step = _LONGEST / _STEPS
    for _ in range(_STEPS):
        # Half a step ahead in position, a whole one in speed: the leapfrog.
        depth = depth + 0.5 * step * speed
        pressed = np.maximum(depth[:, None] - place**2, 0.0)
        elastic = 2.0 * spacing * pressed.sum(axis=1)
        root = np.maximum(depth, 0.0) ** 0.25
        push = np.maximum(elastic + damping * root * speed, 0.0)
        scale = np.divide(push, elastic, out=np.zeros_like(push), where=elastic > 0.0)
        limit = friction[:, None] * scale[:, None] * pressed / STIFFNESS_RATIO
        bent = np.clip(bent + step * sliding[:, None], -limit, limit)
        drag = 2.0 * spacing * STIFFNESS_RATIO * bent.sum(axis=1)
        speed = speed - step * push
        sliding = sliding - step * mobility * drag
        depth = depth + 0.5 * step * speed
        normal, tangential = normal + step * push, tangential + step * drag
    return tangential / normal
