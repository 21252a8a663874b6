"""Errors of poses against the truth of the frames, free of what a campaign has in common.

Lengths of all shots may come out too long together by the scale, and orientations are of a body
frame that nobody defined; both are fitted to the truth over all shots and taken out.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from analysis.imaging.views import View
from analysis.motion.drift import Drift, centre_drift, correlation_time, turn_drift
from analysis.shot import MeasuredShot
from simulators.world.optics import Optics

Floats = NDArray[np.float64]

NEAR = 3.0
"""Stated errors within which frames decide on the scale and the body frame."""


@dataclass(frozen=True, slots=True, eq=False)
class Flight:
    """One sphere on one side of the contact.

    Attributes
    ----------
    shot, sphere, side
        Which it is.
    frames, times_s
        Shape (n,).
    places, place_errors, place_sigmas
        True centres, what was measured of them too much, and stated errors, m, shape (n, 3).
    turned, turns, turn_sigmas
        Frames with an orientation, shape (m,), its rotation vector from the truth, rad, rig axes,
        and stated errors, shape (m, 3).
    place_drift, turn_drift
        Stated slow errors, m and rad; that of each axis of a centre.
    """

    shot: int
    sphere: int
    side: str
    frames: NDArray[np.intp]
    times_s: Floats
    places: Floats
    place_errors: Floats
    place_sigmas: Floats
    turned: NDArray[np.intp]
    turn_times_s: Floats
    turns: Floats
    turn_sigmas: Floats
    place_drift: tuple[Drift, Drift, Drift]
    turn_drift: Drift


def true_centres(truth: Mapping[str, Any], sphere: int, optics: Optics) -> Floats:
    """Return the centres in all frames, m, shape (frames, 3); NaN in the tube."""
    front = _pairs(truth["centres_front_px"], sphere)
    top = _pairs(truth["centres_top_px"], sphere)
    across = (front - np.array(optics.front_origin_px)) / optics.scale_px_per_m
    depth = (optics.top_origin_px[0] - top[:, :1]) / optics.scale_px_per_m
    return np.hstack([across, depth])


def _pairs(rows: Sequence[Sequence[Any]], sphere: int) -> Floats:
    return np.array([[np.nan, np.nan] if own[sphere] is None else own[sphere] for own in rows])


def _true_turns(truth: Mapping[str, Any], sphere: int) -> Rotation:
    rows = [own[sphere] or [1.0, 0.0, 0.0, 0.0] for own in truth["rotation_quaternion"]]
    return Rotation.from_quat(np.array(rows), scalar_first=True)


def body_frame(shots: Sequence[tuple[MeasuredShot, Mapping[str, Any]]], sphere: int) -> Rotation:
    """Return the turn from the true body frame to the measured one, the same in all shots."""
    differences = []
    for shot, truth in shots:
        own = shot.orientations[sphere]
        true = _true_turns(truth, sphere)[own.frames]
        differences.append((true.inv() * Rotation.from_matrix(own.rotation)).as_quat())
    every = Rotation.from_quat(np.concatenate(differences))
    mean = every[len(every) // 2]
    for _ in range(10):
        off = (mean.inv() * every).as_rotvec()
        size = np.linalg.norm(off, axis=1)
        mean = mean * Rotation.from_rotvec(np.median(off[size <= np.median(size) * NEAR], axis=0))
    return mean


def common_scale(shots: Sequence[tuple[MeasuredShot, Mapping[str, Any]]], optics: Optics) -> float:
    """Return by what share all measured lengths are too long."""
    top, bottom = 0.0, 0.0
    for shot, truth in shots:
        for i, own in enumerate(shot.centres):
            true = true_centres(truth, i, optics)[own.frames]
            off = own.position - true
            good = (own.sigma < 3e-5) & (np.abs(off) < 1e-4 + 3e-3 * np.abs(true))
            top += float((off * true)[good].sum())
            bottom += float((true**2)[good].sum())
    return top / bottom


def flights(
    numbers: Sequence[int],
    shots: Sequence[tuple[MeasuredShot, Mapping[str, Any]]],
    optics: Optics,
) -> Iterator[Flight]:
    """Yield all flights; frames exposed during the contact belong to none."""
    scale = common_scale(shots, optics)
    frames = body_frame(shots, 0), body_frame(shots, 1)
    for number, (shot, truth) in zip(numbers, shots, strict=True):
        start = truth["contact_time_s"]
        end = start + truth["contact_duration_s"]
        half = optics.exposure_s / 2
        for i in (0, 1):
            centres, turned = shot.centres[i], shot.orientations[i]
            true = true_centres(truth, i, optics)[centres.frames]
            off = centres.position - true * (1.0 + scale)
            expected = _true_turns(truth, i)[turned.frames] * frames[i]
            turns = (Rotation.from_matrix(turned.rotation) * expected.inv()).as_rotvec()
            sigmas = np.sqrt(np.einsum("nii->ni", turned.covariance))
            rate = float(np.linalg.norm(np.array(truth["spin_before"][i])))
            place_drift, turn = drifts_of(shot, i, rate)
            for side in ("before", "after"):
                when, whirl = shot.times_s[centres.frames], shot.times_s[turned.frames]
                own = when < start - half if side == "before" else when > end + half
                also = whirl < start - half if side == "before" else whirl > end + half
                yield Flight(
                    number,
                    i,
                    side,
                    centres.frames[own],
                    when[own],
                    true[own],
                    off[own],
                    centres.sigma[own],
                    turned.frames[also],
                    whirl[also],
                    turns[also],
                    sigmas[also],
                    place_drift,
                    turn,
                )


def drifts_of(
    shot: MeasuredShot, sphere: int, rate: float
) -> tuple[tuple[Drift, Drift, Drift], Drift]:
    """Return the stated slow errors of centre, by axis, and of turn."""
    tracking = shot.tracking
    lasting = correlation_time(tracking.marker_angle, rate)
    place = centre_drift(tracking.filter_sigma_px, tracking.scales_px_per_m[View.FRONT], lasting)
    turn = turn_drift(tracking.filter_sigma_px, tracking.radii[View.FRONT][sphere], lasting)
    return (place, place, place), turn
