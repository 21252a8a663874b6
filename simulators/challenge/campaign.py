"""A campaign of shots, fired and measured: poses of both spheres in every frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from simulators.challenge.camera import OPTICS, apparent
from simulators.challenge.encounter import follow
from simulators.challenge.launch import Settings, draw_settings, draw_touch
from simulators.challenge.nature import Nature
from simulators.world.description import Sphere

Floats = NDArray[np.float64]

FRAME_RATE_HZ = 1000.0
_LAUNCH, _FRAMES, _NOISE = range(3)


@dataclass(frozen=True, slots=True, eq=False)
class Campaign:
    """What a laboratory knows of S shots of F frames.

    Parameters
    ----------
    settings
        Pressures, offsets and temperatures.
    times_s
        Stated time of each frame from the shot's first, (F,).
    centres
        m, rig axes, (S, F, 2, 3).
    orientations
        Unit quaternions, scalar first, body to rig axes, (S, F, 2, 4).
    centre_sigma_m, rotation_sigma_rad
        Standard errors of a coordinate, and of a rotation about each axis.
    """

    settings: Settings
    times_s: Floats
    centres: Floats
    orientations: Floats
    centre_sigma_m: float
    rotation_sigma_rad: float


@dataclass(frozen=True, slots=True)
class Noise:
    """Standard errors of a centre's coordinate, px, and of a rotation about each axis, rad."""

    centre_px: float = 0.03
    rotation_rad: float = float(np.radians(0.46))


_USUAL_NOISE = Noise()


def run_campaign(
    nature: Nature, seed: int, *, shots: int = 120, frames: int = 24, noise: Noise = _USUAL_NOISE
) -> Campaign:
    """Fire and measure a campaign; the contact falls between the two middle frames.

    The seed draws launches, phases of the frames and noise, each for itself: two natures with one
    seed share them all.
    """
    launch = np.random.default_rng([seed, _LAUNCH])
    settings = draw_settings(shots, launch)
    touch = draw_touch(settings, Sphere(), launch)
    phase = np.random.default_rng([seed, _FRAMES])
    times = np.arange(frames) / FRAME_RATE_HZ
    contact = (frames // 2 - 1 + phase.uniform(0.02, 0.98, shots)) / FRAME_RATE_HZ
    since = (times - contact[:, None]) * (1.0 + nature.frame_rate)
    at_touch = Rotation.random(2 * shots, rng=phase)
    true = follow(nature, settings, touch, since)
    seen = apparent(true.centres, np.broadcast_to(times, since.shape), nature, OPTICS)
    chance = np.random.default_rng([seed, _NOISE])
    sigma = noise.centre_px / OPTICS.scale_px_per_m
    centres = seen + sigma * chance.normal(size=seen.shape)
    error = noise.rotation_rad * chance.normal(size=seen.shape)
    orientations = _orientations(at_touch, true.in_contact, true.in_flight, error)
    return Campaign(settings, times, centres, orientations, sigma, noise.rotation_rad)


def _orientations(at_touch: Rotation, *turns: Floats) -> Floats:
    """Turn the orientations of both spheres at touch by rotation vectors (S, F, 2, 3), in turn."""
    shape = turns[0].shape[:-1]
    start = at_touch.as_quat().reshape(-1, 1, 2, 4)
    turned = Rotation.from_quat(np.broadcast_to(start, (*shape, 4)).reshape(-1, 4))
    for turn in turns:
        turned = Rotation.from_rotvec(turn.reshape(-1, 3)) * turned
    return np.asarray(turned.as_quat(scalar_first=True).reshape(*shape, 4))
