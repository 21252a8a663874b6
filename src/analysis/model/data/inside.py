"""Frames that show the contact itself: they belong to neither side and are left out.

The choice is made once, before models are compared: a set of frames that changed with the model
would make their likelihoods incomparable.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.contact_frames import inside_contact
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import CampaignData, PoseStream
from analysis.model.data.tables import ContactTable, Data
from analysis.model.data.tears import without_torn_tracks
from analysis.model.predict.start import LEAST_FOR_A_LINE, first_states

C = TypeVar("C", PoseData, ContactTable, PoseStream, Data, CampaignData)


def without_contact_frames(data: C) -> C:
    """Leave out every frame whose exposure may hold part of the contact; a table has none."""
    if isinstance(data, ContactTable):
        return data
    if isinstance(data, PoseStream):
        return data.changed(lambda part: _outside(part)[0])
    return PoseData.joined([_outside(part)[0] for part in data.parts()])


def shows_both_sides(data: PoseData) -> NDArray[np.bool_]:
    """Return which shots of two spheres have frames for a line on either side, shape (S,).

    Those that may show the contact itself belong to neither side: a contact may last so long, or
    frames be so few, that none is left.
    """
    outside, tau = _outside(data)
    sides = [(outside.seen & side).sum(axis=1) for side in (tau < 0.0, tau > 0.0)]
    return np.asarray(np.minimum(*sides) >= LEAST_FOR_A_LINE)


def _outside(data: PoseData) -> tuple[PoseData, Floats]:
    """Return the data without frames of the contact, and times from first touch, s, (S, F)."""
    whole = without_torn_tracks(data)
    states = first_states(whole)
    relative = states.before.velocity_b - states.before.velocity_a
    approach = -(relative * states.normal).sum(axis=1)
    tau = whole.times_s - states.time_s[:, None]
    # Poses without a stated exposure are those of instants.
    open_s = whole.camera.exposure_s or 0.0
    return whole.without(inside_contact(tau, approach, whole.bodies, open_s)), tau
