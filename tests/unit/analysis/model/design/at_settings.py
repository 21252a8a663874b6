"""Shots fired at given settings, with the physics of simulators.challenge and known noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from analysis.collision.operator import Body
from analysis.model.data.poses import PoseData
from analysis.setup import CameraSetup
from simulators.challenge.camera import OPTICS, apparent
from simulators.challenge.encounter import follow
from simulators.challenge.launch import Settings, draw_settings, draw_touch
from simulators.challenge.nature import Nature
from simulators.world.description import Sphere

Floats = NDArray[np.float64]

FRAMES, RATE_HZ = 24, 1000.0
CENTRE_PX, TURN_RAD = 0.03, float(np.radians(0.46))


def fired(settings: Settings, nature: Nature, seed: int) -> PoseData:
    """Fire and measure shots at given settings, in their order."""
    rng = np.random.default_rng(seed)
    shots = len(settings.offset_mm)
    touch = draw_touch(settings, Sphere(), rng)
    times = np.arange(FRAMES) / RATE_HZ
    contact = (FRAMES // 2 - 1 + rng.uniform(0.02, 0.98, shots)) / RATE_HZ
    since = (times - contact[:, None]) * (1.0 + nature.frame_rate)
    way = follow(nature, settings, touch, since)
    stated = np.broadcast_to(times, since.shape)
    sigma = CENTRE_PX / OPTICS.scale_px_per_m
    position = apparent(way.centres, stated, nature, OPTICS)
    position = position + sigma * rng.normal(size=position.shape)
    turned = np.repeat(Rotation.random(2 * shots, rng=rng).as_matrix(), FRAMES, axis=0)
    rotation = turned.reshape(shots, 2, FRAMES, 3, 3).swapaxes(1, 2)
    for turn in (way.in_contact, way.in_flight, TURN_RAD * rng.normal(size=position.shape)):
        matrix = Rotation.from_rotvec(turn.reshape(-1, 3)).as_matrix()
        rotation = matrix.reshape(rotation.shape) @ rotation
    return PoseData(
        shots=np.arange(1, shots + 1),
        times_s=stated.copy(),
        position=position,
        position_sigma=np.full(position.shape, sigma),
        rotation=rotation,
        rotation_sigma=np.full(position.shape[:3], TURN_RAD),
        bodies=(Body.sphere(0.0254, 1150.0, 0.4),) * 2,
        gravity=9.80665,
        air_density=1.2,
        covariates={
            "order": settings.order,
            "pressure_a_kpa": settings.pressure_kpa,
            "pressure_b_kpa": settings.pressure_kpa,
            "offset_mm": settings.offset_mm,
        },
        camera=CameraSetup(
            RATE_HZ,
            192,
            240,
            front_view_rows=(88, 192),
            top_view_rows=(0, 88),
            scale_px_per_m=OPTICS.scale_px_per_m,
            front_origin_px=OPTICS.front_origin_px,
            top_origin_px=OPTICS.top_origin_px,
        ),
    )


def drawn_settings(shots: int, seed: int, more: Floats | None = None) -> Settings:
    """Return settings spread evenly, followed by more of (kPa, mm), shape (M, 2)."""
    first = draw_settings(shots, np.random.default_rng(seed))
    more = np.zeros((0, 2)) if more is None else more
    return Settings(
        np.concatenate([first.pressure_kpa, more[:, 0]]),
        np.concatenate([first.offset_mm, more[:, 1]]),
        np.full(shots + len(more), 23.0),
    )
