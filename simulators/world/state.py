"""Snapshots of one sphere: where it is, and how it moves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Pose:
    """Centre (3,) in m and orientation (4,) as a unit quaternion, both in rig axes."""

    centre: NDArray[np.float64]
    orientation: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Motion:
    """Pose with velocity (3,) in m/s and spin (3,) in rad/s, in rig axes."""

    centre: NDArray[np.float64]
    velocity: NDArray[np.float64]
    orientation: NDArray[np.float64]
    spin: NDArray[np.float64]
