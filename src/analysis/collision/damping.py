"""Damping of a normal force and the restitution that it leaves, each from the other.

In units of the reduced mass, the stiffness and the approach speed x'' = -x^p - g x^q x', followed
until the force is gone: T. Schwager and T. Poeschel, Phys. Rev. E 78, 051304 (2008). Integrated in
the same steps as contacts are, so that a head-on contact has the requested restitution.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from analysis.arrays import Floats
from analysis.collision.contact_block import VELOCITY
from analysis.collision.contact_loop import collide
from analysis.collision.force_law import NormalForce

DAMPINGS = np.concatenate([np.linspace(0.0, 1.0, 401), np.linspace(1.02, 8.0, 350)])
"""Up to a restitution of 0.06 of Hertz's force."""
FINE = 1000
"""Steps of a contact whose restitution is right to 1e-5."""


def restitution(damping: Floats, normal: NormalForce, steps: int = FINE) -> Floats:
    """Return e for each dimensionless damping g, shape (...)."""
    return np.asarray(np.interp(damping, DAMPINGS, _table(normal, steps)))


def damping(e: Floats, normal: NormalForce, steps: int = FINE) -> Floats:
    """Return the dimensionless damping g that leaves each restitution, shape (...).

    Above the restitution without damping there is none; below the table's least it is the largest.
    """
    return np.asarray(np.interp(e, _table(normal, steps)[::-1], DAMPINGS[::-1]))


@cache
def _table(normal: NormalForce, steps: int) -> Floats:
    """Integrate contacts head on of every damping; return their e, falling."""
    count = len(DAMPINGS)
    along = np.tile([1.0, 0.0, 0.0], (count, 1))
    # Spheres so large that the overlap is small against them, of the reduced mass 1.
    pair = np.array([1e6, 1e6, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    law = np.array([normal.elastic, normal.damping, 1.0, 0.0])
    units = np.zeros((count, 6))
    units[:, 0], units[:, 1], units[:, 5] = 1.0, DAMPINGS, normal.elastic_duration
    ends, _, _ = collide((along, -along, np.zeros((count, 2, 3))), pair, law, units, steps)
    return np.minimum.accumulate(ends[:, VELOCITY])
