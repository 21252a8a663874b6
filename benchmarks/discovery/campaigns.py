"""Campaigns of the simulators as poses in memory, the way their folders would be read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.spatial.transform import Rotation

from analysis.model.data.columns import ORDER
from analysis.model.data.gather import gather_poses
from analysis.model.data.poses import PoseData
from simulators.challenge.camera import OPTICS, apparent
from simulators.challenge.campaign import FRAME_RATE_HZ, Campaign, Noise, run_campaign
from simulators.challenge.effects import switched
from simulators.challenge.encounter import follow
from simulators.challenge.folder import write_folder
from simulators.challenge.launch import Settings, draw_touch
from simulators.challenge.nature import Nature
from simulators.world.description import Sphere

STATED = Noise()
SILENCE = Noise(0.0, 0.0)
FRAMES = 24
ONE_SETTING = (50.0, 12.0)
"""Pressure, kPa, and offset, mm, of a campaign that varies neither."""


def campaign(
    amplitudes: Mapping[str, float],
    seed: int,
    shots: int,
    *,
    noise: Noise = STATED,
    one_setting: bool = False,
) -> PoseData:
    """Return poses of a campaign that hides these effects, sigmas as stated whatever the noise."""
    nature = switched(amplitudes)
    if one_setting:
        return posed(_at_one_setting(nature, seed, shots))
    return posed(run_campaign(nature, seed, shots=shots, noise=noise))


def _at_one_setting(nature: Nature, seed: int, shots: int) -> Campaign:
    """Fire a campaign whose pressure and offset never change; the launch scatters as ever."""
    rng = np.random.default_rng(seed)
    pressure, offset = ONE_SETTING
    room = 23.0 + np.sin(np.arange(shots) / 9.0)
    settings = Settings(np.full(shots, pressure), np.full(shots, offset), room)
    touch = draw_touch(settings, Sphere(), rng)
    times = np.arange(FRAMES) / FRAME_RATE_HZ
    contact = (FRAMES // 2 - 1 + rng.uniform(0.02, 0.98, shots)) / FRAME_RATE_HZ
    since = (times - contact[:, None]) * (1.0 + nature.frame_rate)
    way = follow(nature, settings, touch, since)
    seen = apparent(way.centres, np.broadcast_to(times, since.shape), nature, OPTICS)
    sigma = STATED.centre_px / OPTICS.scale_px_per_m
    turned = Rotation.from_rotvec(rng.normal(0, STATED.rotation_rad, (since.size * 2, 3)))
    for turns in (way.in_flight, way.in_contact):
        turned = turned * Rotation.from_rotvec(turns.reshape(-1, 3))
    centres = seen + rng.normal(0, sigma, seen.shape)
    quaternions = turned.as_quat(scalar_first=True).reshape(*seen.shape[:-1], 4)
    return Campaign(settings, times, centres, quaternions, sigma, STATED.rotation_rad)


def posed(fired: Campaign) -> PoseData:
    """Return the poses of a fired campaign in memory, sigmas as stated whatever the noise."""
    settings, stated = fired.settings, _stated()
    shots = len(settings.offset_mm)
    shape = fired.centres.shape
    turned = Rotation.from_quat(fired.orientations.reshape(-1, 4), scalar_first=True)
    return replace(
        stated,
        shots=np.arange(1, shots + 1),
        times_s=np.tile(fired.times_s, (shots, 1)),
        position=fired.centres,
        position_sigma=np.full(shape, stated.position_sigma[0, 0, 0, 0]),
        rotation=turned.as_matrix().reshape(*shape, 3),
        rotation_sigma=np.full(shape[:3], stated.rotation_sigma[0, 0, 0]),
        covariates={
            "pressure_a_kpa": settings.pressure_kpa,
            "pressure_b_kpa": settings.pressure_kpa,
            "offset_mm": settings.offset_mm,
            "temperature_c": settings.temperature_c,
            ORDER: settings.order,
        },
    )


@cache
def _stated() -> PoseData:
    """Return what the simulators' folders say of spheres, camera and noise."""
    with TemporaryDirectory() as made:
        folder = Path(made) / "campaign"
        write_folder(folder, run_campaign(Nature(), 0, shots=3, noise=STATED))
        return gather_poses(folder)[1]
