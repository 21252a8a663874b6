"""Whole shots of the simulated rig, to measure with the mirror and without (thesis, table 3.3)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from simulators.world import Launch, WorldDescription, render_shot
from simulators.world.optics import Optics

PRESSURES_KPA = (40.0, 70.0)
OFFSETS_M = (0.012, 0.016, 0.019)
"""Oblique, as the shot of table 3.3 was: its v_s is 2.5 times its v_n."""


class FilmedShot(NamedTuple):
    """Frames (N, rows, columns) at times (N,) in s, with camera and spheres as they are known."""

    frames: NDArray[np.uint8]
    times_s: NDArray[np.float64]
    optics: Optics
    frame_rate_hz: float
    diameter_m: float
    gravity_m_per_s2: float


def filmed_shot(number: int, seed: int) -> FilmedShot:
    """Fire and film one shot, the settings going round with its number."""
    world = WorldDescription()
    pressure = PRESSURES_KPA[number % len(PRESSURES_KPA)]
    offset = OFFSETS_M[number // len(PRESSURES_KPA) % len(OFFSETS_M)]
    filmed = render_shot(world, Launch(pressure, pressure, offset), seed, shot=number + 1)
    return FilmedShot(
        frames=filmed.frames,
        times_s=filmed.times_s,
        optics=world.optics,
        frame_rate_hz=1000.0,
        diameter_m=world.sphere_a.diameter_m,
        gravity_m_per_s2=world.environment.gravity_m_per_s2,
    )
