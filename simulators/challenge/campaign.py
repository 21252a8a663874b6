"""A campaign of shots, fired and measured: poses of both spheres in every frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from simulators.challenge.camera import OPTICS, apparent
from simulators.challenge.encounter import Way, follow
from simulators.challenge.launch import PRESSURES_KPA, Settings, draw_settings, draw_touch
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


@dataclass(frozen=True, slots=True, eq=False)
class Fired:
    """S shots as they really were, in F frames.

    Parameters
    ----------
    settings
        Pressures, offsets and temperatures.
    times_s
        Stated time of each frame from the shot's first, (F,).
    way
        Centres and rotations of both spheres.
    at_touch
        Orientations at first touch, 2 S of them, a before b in each shot.
    """

    settings: Settings
    times_s: Floats
    way: Way
    at_touch: Rotation

    def orientations(self, error: Floats | None = None) -> Floats:
        """Return unit quaternions, scalar first, body to rig axes, (S, F, 2, 4).

        `error` are rotation vectors (S, F, 2, 3) by which they are turned last.
        """
        shape = self.way.centres.shape[:-1]
        start = self.at_touch.as_quat().reshape(-1, 1, 2, 4)
        turned = Rotation.from_quat(np.broadcast_to(start, (*shape, 4)).reshape(-1, 4))
        turns = [self.way.in_contact, self.way.in_flight]
        for turn in turns if error is None else [*turns, error]:
            turned = Rotation.from_rotvec(turn.reshape(-1, 3)) * turned
        return np.asarray(turned.as_quat(scalar_first=True).reshape(*shape, 4))


def run_campaign(
    nature: Nature, seed: int, *, shots: int = 120, frames: int = 24, noise: Noise = _USUAL_NOISE
) -> Campaign:
    """Fire and measure a campaign; the contact falls between the two middle frames.

    The seed draws launches, phases of the frames and noise, each for itself: two natures with one
    seed share them all.
    """
    return measure(fire(nature, seed, shots=shots, frames=frames), nature, seed, noise)


def fire(
    nature: Nature,
    seed: int,
    *,
    shots: int,
    frames: int = 24,
    pressures_kpa: tuple[float, float] = PRESSURES_KPA,
) -> Fired:
    """Fire the shots of a campaign, and follow both spheres through every frame."""
    launch = np.random.default_rng([seed, _LAUNCH])
    settings = draw_settings(shots, launch, pressures_kpa)
    touch = draw_touch(settings, Sphere(), launch)
    phase = np.random.default_rng([seed, _FRAMES])
    times = np.arange(frames) / FRAME_RATE_HZ
    contact = (frames // 2 - 1 + phase.uniform(0.02, 0.98, shots)) / FRAME_RATE_HZ
    since = (times - contact[:, None]) * (1.0 + nature.frame_rate)
    at_touch = Rotation.random(2 * shots, rng=phase)
    return Fired(settings, times, follow(nature, settings, touch, since), at_touch)


def measure(fired: Fired, nature: Nature, seed: int, noise: Noise) -> Campaign:
    """Return the poses that are read off the pictures, with noise of the stated size."""
    centres = fired.way.centres
    times = np.broadcast_to(fired.times_s, centres.shape[:2])
    seen = apparent(centres, times, nature, OPTICS)
    chance = np.random.default_rng([seed, _NOISE])
    sigma = noise.centre_px / OPTICS.scale_px_per_m
    places = seen + sigma * chance.normal(size=seen.shape)
    error = noise.rotation_rad * chance.normal(size=seen.shape)
    turned = fired.orientations(error)
    return Campaign(fired.settings, fired.times_s, places, turned, sigma, noise.rotation_rad)
