"""A steel sphere let go by a magnet, falling through air (thesis, chapter 6)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from simulators.qualification.single import UPRIGHT, single_sphere_camera
from simulators.world.state import Pose

DIAMETER_M, DIAMETER_PX = 0.0254, 33.0
GRAVITY_M_PER_S2 = 9.80236
"""Normal gravity at the thesis's place, 40.74 degrees north: 385.92 inches/s^2."""
STEEL_KG_PER_M3, AIR_KG_PER_M3, DRAG_COEFFICIENT = 7830.0, 1.2, 0.45
INTERVAL_S, FRAMES = 0.008, 12
"""Every second frame of 250 a second; the thesis has over ten."""
EXPOSURE_S = 2.0e-4
_START_PX = (24.0, 120.0)


class FilmedDrop(NamedTuple):
    """Frames (N, rows, columns) at times (N,) in s, the sphere's diameter and the true gravity."""

    frames: NDArray[np.uint8]
    times_s: NDArray[np.float64]
    diameter_m: float
    gravity_m_per_s2: float


def fallen_m(time_s: float) -> float:
    """Return how far the sphere has fallen in m: quadratic drag and buoyancy, from rest.

    x = (w^2 / a) ln cosh(a t / w) with a = g (1 - air / steel) and w the terminal speed.
    """
    if time_s <= 0.0:
        return 0.0
    density = AIR_KG_PER_M3 / STEEL_KG_PER_M3
    pull = GRAVITY_M_PER_S2 * (1.0 - density)
    terminal = math.sqrt(4.0 / 3.0 * pull * DIAMETER_M / (DRAG_COEFFICIENT * density))
    return terminal**2 / pull * math.log(math.cosh(pull * time_s / terminal))


def filmed_drop(seed: int) -> FilmedDrop:
    """Let the sphere go at a random time before the first frame, and film it."""
    rng = np.random.default_rng([seed, 1])
    camera = single_sphere_camera(DIAMETER_M, DIAMETER_PX, exposure_s=EXPOSURE_S)
    scale = camera.optics.scale_px_per_m
    start = (np.array(_START_PX) + rng.uniform(-0.5, 0.5, 2)) / scale
    let_go_s = -rng.uniform(0.0, INTERVAL_S)

    def poses(time_s: float) -> list[Pose]:
        below = start[0] + fallen_m(time_s - let_go_s)
        return [Pose(np.array([below, start[1], 0.0]), UPRIGHT)]

    times = INTERVAL_S * np.arange(FRAMES, dtype=np.float64)
    frames = np.stack([camera.take(poses, time, rng) for time in times.tolist()])
    return FilmedDrop(frames, times, DIAMETER_M, GRAVITY_M_PER_S2)
