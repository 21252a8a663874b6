"""Frames that show the contact itself: they belong to neither side and are left out.

The choice is made once, before models are compared: a set of frames that changed with the model
would make their likelihoods incomparable.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.contact_frames import inside_contact
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import CampaignData, PoseStream
from analysis.model.data.tables import ContactTable, Data
from analysis.model.predict.start import LEAST_FOR_A_LINE, first_states
from analysis.motion.tears import BEYOND, label_side
from analysis.schema.verdict import TornTrack

STRONG_DRAG = 1.0
"""Drag coefficient beyond that of any smooth sphere in air."""
MOST_CUT, LEAST_LEFT = 0.5, 4
"""Share of a flight's frames: if more are cut and few are left, those beside the contact may be
wrong, and all stay."""


def without_torn_tracks(data: PoseData) -> PoseData:
    """Cut each track where it leaves free flight for good, before any law sees it.

    An outline that leaves its view, or is taken for another, sends a track away from free flight
    at a stated error of micrometres (`analysis.motion.tears`).
    Single bad frames stay: whether they are is judged with the law.
    """
    seen = np.asarray(np.isfinite(data.position_sigma).any(axis=3))
    both = np.asarray(np.isfinite(data.position_sigma).all(axis=(2, 3)))
    apart = np.linalg.norm(data.position[:, :, 1] - data.position[:, :, 0], axis=2)
    if data.on_plate:
        both, apart = data.seen, np.abs(data.times_s)
    nearest = np.where(both, apart, np.inf).argmin(axis=1)
    cut = np.zeros(seen.shape, dtype=np.bool_)
    tracks: list[TornTrack] = []
    for s in np.flatnonzero(both.any(axis=1)):
        for i in (0,) if data.on_plate else (0, 1):
            frames = np.flatnonzero(seen[s, :, i])
            for side in (frames[frames < nearest[s]][::-1], frames[frames > nearest[s]]):
                beyond = side[_beyond(data, int(s), i, side, int(nearest[s]))]
                cut[s, beyond, i] = True
                if beyond.size:
                    ends = int(beyond.min()), int(beyond.max())
                    tracks.append((int(data.shots[s]), "ab"[i], *ends))
    if not cut.any():
        return data
    return replace(
        data,
        position_sigma=np.where(cut[..., None], np.inf, data.position_sigma),
        rotation_sigma=np.where(cut, np.inf, data.rotation_sigma),
        torn=tuple(tracks),
    )


def _beyond(
    data: PoseData, shot: int, sphere: int, frames: NDArray[np.intp], contact: int
) -> NDArray[np.bool_]:
    """Return which frames of one side, from the contact outward, lie beyond a tear."""
    tau = data.times_s[shot, frames] - data.times_s[shot, contact]
    body = data.bodies[sphere]
    slows = STRONG_DRAG * data.air_density * np.pi * body.radius**2 / (2 * body.mass)
    labels = label_side(
        tau,
        data.position[shot, frames, sphere],
        data.position_sigma[shot, frames, sphere],
        gravity=data.gravity,
        slows_per_m=slows,
    )
    beyond = np.asarray(labels == BEYOND)
    left = int((~beyond).sum())
    if left < LEAST_LEFT and beyond.sum() > MOST_CUT * len(beyond):
        return np.zeros_like(beyond)
    return beyond


C = TypeVar("C", PoseData, ContactTable, PoseStream, Data, CampaignData)


def without_contact_frames(data: C) -> C:
    """Leave out every frame whose exposure may hold part of the contact; a table has none."""
    if isinstance(data, ContactTable):
        return data
    if isinstance(data, PoseStream):
        return data.changed(lambda part: outside_contact(part)[0])
    return PoseData.joined([outside_contact(part)[0] for part in data.parts()])


def shows_both_sides(data: PoseData) -> NDArray[np.bool_]:
    """Return which shots of two spheres have frames for a line on either side, shape (S,).

    Those that may show the contact itself belong to neither side: a contact may last so long, or
    frames be so few, that none is left.
    """
    outside, tau = outside_contact(data)
    sides = [(outside.seen & side).sum(axis=1) for side in (tau < 0.0, tau > 0.0)]
    return np.asarray(np.minimum(*sides) >= LEAST_FOR_A_LINE)


def outside_contact(data: PoseData) -> tuple[PoseData, Floats]:
    """Return the data without frames of the contact, and times from first touch, s, (S, F)."""
    whole = without_torn_tracks(data)
    states = first_states(whole)
    relative = states.before.velocity_b - states.before.velocity_a
    approach = -(relative * states.normal).sum(axis=1)
    tau = whole.times_s - states.time_s[:, None]
    # Poses without a stated exposure are those of instants.
    open_s = whole.camera.exposure_s or 0.0
    return whole.without(inside_contact(tau, approach, whole.bodies, open_s)), tau
