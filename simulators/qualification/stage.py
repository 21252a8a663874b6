"""A sphere on a micro-positioning stage, moved in quarters of a pixel (thesis, section 4.2)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from simulators.qualification.single import UPRIGHT, single_sphere_camera, standing
from simulators.world.state import Pose

DIAMETER_M, DIAMETER_PX = 0.0254, 40.0
STEPS, STEP_PX = 8, 0.25
_MIDDLE_PX = (96.0, 120.0)


class StageRun(NamedTuple):
    """Frames (N, rows, columns) and how far the stage stood from its start (N, 2), pixels.

    Displacements are (row, column).
    """

    frames: NDArray[np.uint8]
    moved_px: NDArray[np.float64]


def stage_run(direction: tuple[float, float], seed: int) -> StageRun:
    """Move the sphere by eight steps of a quarter of a pixel and take a picture at each.

    The start lies at a random fraction of a pixel.

    Parameters
    ----------
    direction
        Share of each step along (row, column): (0, 1), (1, 0) or (1, 1) in the thesis.
    """
    rng = np.random.default_rng([seed, *(round(100 * part) for part in direction)])
    camera = single_sphere_camera(DIAMETER_M, DIAMETER_PX, exposure_s=0.0)
    moved = STEP_PX * np.arange(STEPS + 1)[:, None] * np.array(direction)
    start = start_px(rng)
    frames = []
    for place in (start + moved) / camera.optics.scale_px_per_m:
        pose = Pose(np.array([*place, 0.0]), UPRIGHT)
        frames.append(camera.take(standing(pose), 0.0, rng))
    return StageRun(np.stack(frames), moved)


def start_px(rng: np.random.Generator) -> NDArray[np.float64]:
    """Return where the sphere's centre starts, (row, column): the middle, at a random fraction."""
    return np.array(_MIDDLE_PX) + rng.uniform(-0.5, 0.5, 2)
