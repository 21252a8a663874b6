"""How long a contact may last, and which frames may show part of it: they belong to neither side.

A frame of a contact shows no one state. Which frames those are follows from the approach before
contact alone, whatever law the contact obeys.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.force_law import hertz_duration, stated_modulus
from analysis.collision.operator import Body
from analysis.material import NAMED

MARGIN_BEFORE_S = 0.06e-3
DURATIONS_AFTER = 1.6
SLOWEST = 0.05
"""Approach speed, m/s, below which a contact is taken to last no longer."""


def longest_contact(approach: Floats, bodies: tuple[Body, Body]) -> Floats:
    """Return how long an elastic contact lasts, s, for approach speeds in m/s.

    Of the bodies' material, where it is stated, else of soft nylon.
    """
    modulus = stated_modulus(bodies) or NAMED["nylon-soft"].contact_modulus
    return np.asarray(hertz_duration(modulus, bodies) * np.maximum(approach, SLOWEST) ** -0.2)


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
    lasting = DURATIONS_AFTER * longest_contact(approach, bodies)
    begun = since_touch_s > -(MARGIN_BEFORE_S + half_open)
    return np.asarray(begun & (since_touch_s < lasting[..., None] + half_open))
