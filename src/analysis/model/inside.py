"""Frames that show the contact itself: they belong to neither side and are left out.

The choice is made once, before models are compared: a set of frames that changed with the model
would make their likelihoods incomparable.
"""

from __future__ import annotations

from typing import overload

import numpy as np
from numpy.typing import NDArray

from analysis.collision.operator import Body
from analysis.model.poses import PoseData
from analysis.model.start import first_states
from analysis.model.tables import ContactTable, Data

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


@overload
def without_contact_frames(data: PoseData) -> PoseData: ...


@overload
def without_contact_frames(data: Data) -> Data: ...


def without_contact_frames(data: Data) -> Data:
    """Leave out every frame whose exposure may hold part of the contact; a table has none."""
    if isinstance(data, ContactTable):
        return data
    states = first_states(data)
    relative = states.before.velocity_b - states.before.velocity_a
    approach = -(relative * states.normal).sum(axis=1)
    lasting = DURATIONS_AFTER * hertz_duration(approach, data.bodies)
    tau = data.times_s - states.time_s[:, None]
    # Poses without a stated exposure are those of instants.
    half_open = (data.camera.exposure_s or 0.0) / 2
    inside = tau > -(MARGIN_BEFORE_S + half_open)
    return data.without(inside & (tau < lasting[:, None] + half_open))
