"""A stage or a disk before the recorder, in lab time: nothing here fires."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simulators.qualification.disk import filmed_disk
from simulators.qualification.single import UPRIGHT, single_sphere_camera, standing
from simulators.qualification.stage import DIAMETER_M, start_px
from simulators.world.chance import noise_chance
from simulators.world.optics import Optics, picture_rows
from simulators.world.state import Pose

Picture = NDArray[np.uint8]
APPARATUS = ("stage", "disk")


@dataclass(frozen=True, slots=True)
class BenchScene:
    """What a configuration says of a stage or a disk.

    Parameters
    ----------
    apparatus
        One of `APPARATUS`.
    rate_rpm
        Turns of the disk a minute.
    px_per_mm
        Way of the image, (row, column) in pixels, for each mm of the slide.
    scale_px_per_m
        Of the image of the stage's sphere.
    exposure_s
        Time the shutter is open.
    """

    apparatus: str
    rate_rpm: float = 0.0
    px_per_mm: tuple[float, float] = (0.0, 0.0)
    scale_px_per_m: float = 1.0
    exposure_s: float = 1.0e-4

    @classmethod
    def of(cls, scene: Mapping[str, Any]) -> BenchScene:
        """Read a scene whose `apparatus` is one of `APPARATUS`."""
        exposure_us = scene.get("exposure_us")
        exposure_s = 1.0e-4 if exposure_us is None else 1e-6 * exposure_us
        if scene["apparatus"] == "disk":
            return cls("disk", rate_rpm=scene["disk"]["rate_rpm"], exposure_s=exposure_s)
        stage = scene["stage"]
        scale, direction = stage["scale_px_per_m"], stage.get("direction", "x")
        per_mm = (1e-3 * scale * ("y" in direction), 1e-3 * scale * ("x" in direction))
        return cls("stage", px_per_mm=per_mm, scale_px_per_m=scale, exposure_s=exposure_s)


class BenchWorld:
    """Pictures of a stage or a disk at any lab time.

    Parameters
    ----------
    scene
        What stands before the camera.
    seed
        Of its start and of the noise.
    position_mm
        Where the slide stands at a lab time.
    """

    def __init__(self, scene: BenchScene, seed: int, position_mm: Callable[[float], float]) -> None:
        self._seed, self._position_mm = seed, position_mm
        self._look = self._disk(scene) if scene.apparatus == "disk" else self._stage(scene)

    @property
    def fires(self) -> int:
        """Nothing fires."""
        return 0

    def fire(self, _: object) -> int:
        """Take whatever an output does: nothing hangs on it."""
        return 0

    def picture(self, time_s: float, rows: int | None = None) -> Picture:
        """Return the frame (rows, columns) with mid-exposure at a lab time."""
        first, last = picture_rows(Optics(), rows)
        return self._look(time_s)[first:last]

    def _disk(self, scene: BenchScene) -> Callable[[float], Picture]:
        rng = np.random.default_rng([self._seed, 2])
        disk = filmed_disk(rng, scene.rate_rpm, scene.exposure_s)
        return lambda time_s: disk.take(time_s, noise_chance(self._seed, time_s))

    def _stage(self, scene: BenchScene) -> Callable[[float], Picture]:
        scale = scene.scale_px_per_m
        camera = single_sphere_camera(DIAMETER_M, DIAMETER_M * scale, exposure_s=0.0)
        start = start_px(np.random.default_rng([self._seed, 3]))
        origin_mm = None

        def look(time_s: float) -> Picture:
            nonlocal origin_mm
            stands_mm = self._position_mm(time_s)
            origin_mm = stands_mm if origin_mm is None else origin_mm
            place = start + (stands_mm - origin_mm) * np.array(scene.px_per_mm)
            pose = Pose(np.array([*(place / scale), 0.0]), UPRIGHT)
            return camera.take(standing(pose), 0.0, noise_chance(self._seed, time_s))

        return look
