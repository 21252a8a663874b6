"""How long a contact may last, and which frames may show part of it: they belong to neither side.

A frame of a contact shows no one state. Which frames those are follows from the approach before
contact alone, whatever law the contact obeys.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.collision.operator import Body

Floats = NDArray[np.float64]

YOUNGS_MODULUS = 2.3e9
"""Nylon at the soft end of the thesis's table 7.1, Pa: the longest contact."""
POISSON_RATIO = 0.25
MARGIN_BEFORE_S = 0.06e-3
DURATIONS_AFTER = 1.6
SLOWEST = 0.05


def hertz_duration(approach: Floats, bodies: tuple[Body, Body]) -> Floats:
    """Return how long an elastic Hertzian contact lasts, s, for approach speeds in m/s.

    t = 2.94 x / v with x = (5 m* v^2 / (4 k))^(2/5), k = (4/3) E* sqrt(R*): K. L. Johnson, Contact
    Mechanics (1985), section 11.4.
    """
    a, b = bodies
    mass = 1 / (1 / a.mass + 1 / b.mass)
    radius = 1 / (1 / a.radius + 1 / b.radius)
    modulus = YOUNGS_MODULUS / (2 * (1 - POISSON_RATIO**2))
    stiffness = 4 / 3 * modulus * np.sqrt(radius)
    speed = np.maximum(approach, SLOWEST)
    depth = (1.25 * mass * speed**2 / stiffness) ** 0.4
    return np.asarray(2.94 * depth / speed)


def inside_contact(
    since_touch_s: Floats, approach: Floats, bodies: tuple[Body, Body], exposure_s: float
) -> NDArray[np.bool_]:
    """Return which frames may have been exposed during the contact.

    Parameters
    ----------
    since_touch_s
        Times of the frames from first touch, s, shape (..., frames).
    approach
        Speed of approach along the normal, m/s, shape (...).
    exposure_s
        Time that the shutter was open, centred on a frame's time; 0: poses of instants.
    """
    half_open = exposure_s / 2
    lasting = DURATIONS_AFTER * hertz_duration(approach, bodies)
    begun = since_touch_s > -(MARGIN_BEFORE_S + half_open)
    return np.asarray(begun & (since_touch_s < lasting[..., None] + half_open))
