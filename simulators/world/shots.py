"""Rendered shots with their truth, for tests of analysis."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from simulators.world.chance import marked_camera, noise_chance, shot_chance
from simulators.world.description import WorldDescription
from simulators.world.encounter import FLIGHT_LASTS_S, Encounter, simulate
from simulators.world.launch import Launch
from simulators.world.optics import picture_rows
from simulators.world.pinhole import seen_at
from simulators.world.state import Pose
from simulators.world.truth import FilmedTruth, contact_truth


class RenderedShot(NamedTuple):
    """Frames (N, rows, columns), mid-exposure times (N,) in s from the first, and the truth."""

    frames: NDArray[np.uint8]
    times_s: NDArray[np.float64]
    truth: FilmedTruth


def render_shot(
    description: WorldDescription,
    launch: Launch,
    seed: int,
    *,
    frame_rate_hz: float = 1000.0,
    frames: int = 24,
    shot: int = 1,
    rows: int | None = None,
) -> RenderedShot:
    """Fire one shot and film it, with the contact about the middle of the frames.

    The contact falls at a random phase between two frames. Spheres that miss are filmed about
    the middle of the field. `shot` numbers the shots of one seed, which share their markers. Fewer
    `rows` than a full frame are those about its middle (`picture_rows`), and the truth counts from
    the first of them.
    """
    rng = shot_chance(seed, shot)
    encounter = simulate(description, launch, rng)
    camera = marked_camera(description, seed)
    first_s = _middle(encounter) - (frames / 2.0 - 1.0 + rng.uniform()) / frame_rate_hz
    times = np.arange(frames) / frame_rate_hz
    pictures = [
        # The noise is that of the shot: its times alone would repeat from shot to shot.
        camera.take(encounter.poses, first_s + time, noise_chance(seed, shot + time), rows)
        for time in times.tolist()
    ]
    truth = _truth(description, launch, encounter, shot, first_s + times)
    first_row = picture_rows(description.optics, rows)[0]
    for view in (truth["centres_front_px"], truth["centres_top_px"]):
        for pair in view:
            pair[:] = [None if at is None else (at[0] - first_row, at[1]) for at in pair]
    return RenderedShot(np.stack(pictures), times, truth)


def _middle(encounter: Encounter) -> float:
    """Return the first touch, or when the spheres of a missed shot are nearest the middle."""
    if encounter.contact is not None:
        return encounter.contact.start_s

    def distance(time_s: float) -> float:
        poses = encounter.poses(time_s)
        return sum(1.0 if pose is None else abs(float(pose.centre[1])) for pose in poses)

    milliseconds = range(round(FLIGHT_LASTS_S * 1e3))
    return min((count * 1e-3 for count in milliseconds), key=distance)


def _truth(
    description: WorldDescription,
    launch: Launch,
    encounter: Encounter,
    shot: int,
    times_s: NDArray[np.float64],
) -> FilmedTruth:
    spheres = (description.sphere_a, description.sphere_b)
    contact = contact_truth(encounter.contact, spheres)
    if encounter.contact is not None:
        contact["contact_time_s"] = encounter.contact.start_s - float(times_s[0])
    poses = [encounter.poses(time) for time in times_s.tolist()]

    def seen(pose: Pose | None, view: int) -> tuple[float, float] | None:
        return None if pose is None else seen_at(description.optics, pose.centre)[view]

    return FilmedTruth(
        **contact,
        shot=shot,
        fire_a_s=launch.fire_a_s,
        fire_b_s=launch.fire_b_s,
        pressure_a_kpa=launch.pressure_a_kpa,
        pressure_b_kpa=launch.pressure_b_kpa,
        offset_m=launch.offset_m,
        centres_front_px=[[seen(pose, 0) for pose in pair] for pair in poses],
        centres_top_px=[[seen(pose, 1) for pose in pair] for pair in poses],
        rotation_quaternion=[
            [None if pose is None else pose.orientation.tolist() for pose in pair] for pair in poses
        ],
    )
