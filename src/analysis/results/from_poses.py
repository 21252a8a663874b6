"""Impacts of a campaign from its poses: every shot from its own two flights, by itself.

What right after tracking is measured of a shot (`analysis.two_sides`) is measured here of the same
poses: no law, and no scale or outline that other shots have bent. A shot is left out when its poses
are no free flight, never because its impact is unlike the others.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from analysis.arrays import Floats
from analysis.errors import ShotRefusedError
from analysis.model.data.poses import PoseData
from analysis.results.bounces import bounce_impacts
from analysis.results.impacts import (
    SHARED,
    V_N,
    V_N_AFTER,
    V_S,
    V_S_AFTER,
    Impacts,
    LeftOut,
    measured_impacts,
)
from analysis.scene import Scene
from analysis.shot_poses import ShotPoses
from analysis.two_sides import MOST_FLIGHT_CHI2, TwoSides, measure_two_sides


def pose_impacts(data: PoseData) -> Impacts:
    """Measure the impact of every shot from its poses alone.

    Errors that are not stated are taken from the scatter of all shots about their free flights.
    Where stated ones are too small throughout, the limit for a bent track is enlarged as much.
    """
    scene = scene_of(data)
    if data.on_plate:
        return bounce_impacts(data, scene)
    scenes = [replace(scene, slow=data.own_slow.get(int(n), data.slow)) for n in data.shots]

    def measured(given: PoseData) -> list[TwoSides | ShotRefusedError]:
        pairs = zip(_each(given), scenes, strict=True)
        return [_measured(poses, own, np.inf) for poses, own in pairs]

    first = measured(data)
    whole = [one for one in first if isinstance(one, TwoSides)]
    tracks = _typical([one.flight_chi2 for one in whole])
    if data.estimated:
        turns = _typical([one.spin_chi2 for one in whole])
        data = data.with_sigmas(
            np.sqrt(tracks) * data.position_sigma, np.sqrt(turns) * data.rotation_sigma
        )
        first, tracks = measured(data), 1.0
    most = MOST_FLIGHT_CHI2 * max(1.0, tracks)
    # The limit changes no number: only shots beyond it are measured again, for the reason.
    found = [
        _measured(poses, own, most)
        if isinstance(one, TwoSides) and (one.flight_chi2 > most).any()
        else one
        for one, poses, own in zip(first, _each(data), scenes, strict=True)
    ]
    return _impacts(data, found)


def scene_of(data: PoseData) -> Scene:
    """Return bodies and surroundings of a campaign of poses."""
    return Scene(
        bodies=data.bodies,
        gravity=data.gravity,
        air_density=data.air_density,
        drag_coefficient=data.drag_of_flights,
        drag_sigma=data.drag_sigma,
        # Poses without a stated exposure are those of instants.
        exposure_s=data.camera.exposure_s or 0.0,
        slow=data.slow,
    )


def _each(data: PoseData) -> Iterator[ShotPoses]:
    """Return the poses of each shot, without the frames that only fill it up."""
    for row in range(len(data.shots)):
        shown = np.flatnonzero(data.measured[row].any(axis=(1, 2)))
        yield ShotPoses(
            frames=shown,
            times_s=data.times_s[row, shown],
            position=data.position[row, shown],
            position_sigma=data.position_sigma[row, shown],
            rotation=data.rotation[row, shown],
            rotation_sigma=data.rotation_sigma[row, shown],
            turn_shape=data.turns[row, shown],
        )


def _measured(poses: ShotPoses, scene: Scene, most_chi2: float) -> TwoSides | ShotRefusedError:
    try:
        return measure_two_sides(poses, scene, most_chi2=most_chi2)
    except ShotRefusedError as refusal:
        return refusal


def _typical(chi2: list[Floats]) -> float:
    """Return the median chi-squared per degree of freedom, 1 without any."""
    every = np.concatenate([np.empty(0), *chi2])
    every = every[np.isfinite(every)]
    return float(np.median(every)) if every.size else 1.0


def _impacts(data: PoseData, found: list[TwoSides | ShotRefusedError]) -> Impacts:
    shots = len(found)
    velocities = np.full((shots, 4), np.nan)
    covariance, shared = np.tile(np.eye(4), (shots, 1, 1)), np.zeros((shots, SHARED, 4))
    left_out = []
    for row, one in enumerate(found):
        if isinstance(one, ShotRefusedError):
            left_out.append(LeftOut(int(data.shots[row]), one.reason))
            continue
        impact = one.impact
        covariance[row], shared[row] = impact.covariance, impact.shared
        velocities[row, [V_N, V_N_AFTER]] = impact.v_n.value, impact.v_n_after.value
        if impact.v_s is not None and impact.v_s_after is not None:
            velocities[row, [V_S, V_S_AFTER]] = impact.v_s.value, impact.v_s_after.value
    measured = ~np.isin(data.shots, [one.shot for one in left_out])
    impacts = measured_impacts(
        data.shots[measured],
        velocities[measured],
        covariance[measured],
        data.bodies,
        shared[measured],
    )
    return replace(impacts, left_out=(*left_out, *impacts.left_out))
