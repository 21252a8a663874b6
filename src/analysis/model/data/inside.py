"""Frames that show the contact itself: they belong to neither side and are left out.

The choice is made once, before models are compared: a set of frames that changed with the model
would make their likelihoods incomparable.
"""

from __future__ import annotations

from typing import TypeVar

from analysis.collision.contact_frames import inside_contact
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import CampaignData, PoseStream
from analysis.model.data.tables import ContactTable, Data
from analysis.model.data.tears import without_torn_tracks
from analysis.model.predict.start import first_states

C = TypeVar("C", PoseData, ContactTable, PoseStream, Data, CampaignData)


def without_contact_frames(data: C) -> C:
    """Leave out every frame whose exposure may hold part of the contact; a table has none."""
    if isinstance(data, ContactTable):
        return data
    if isinstance(data, PoseStream):
        return data.changed(_outside)
    return PoseData.joined([_outside(part) for part in data.parts()])


def _outside(data: PoseData) -> PoseData:
    whole = without_torn_tracks(data)
    states = first_states(whole)
    relative = states.before.velocity_b - states.before.velocity_a
    approach = -(relative * states.normal).sum(axis=1)
    tau = whole.times_s - states.time_s[:, None]
    # Poses without a stated exposure are those of instants.
    open_s = whole.camera.exposure_s or 0.0
    return whole.without(inside_contact(tau, approach, whole.bodies, open_s))
