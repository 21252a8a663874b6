"""Spheres as the simulated camera shows them, and the set-up that belongs to them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.setup import CameraSetup, Environment, Setup, SphereSetup
from simulators.world import Launch, RenderedShot, WorldDescription, render_shot
from simulators.world.description import Sphere
from simulators.world.optics import Optics
from simulators.world.render import Camera
from simulators.world.state import Pose

Floats = NDArray[np.float64]

OPTICS = Optics(exposure_s=0.0)
RADIUS_PX = Sphere().radius_m * OPTICS.scale_px_per_m
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


def setup_of(description: WorldDescription, frame_rate_hz: float = 1000.0) -> Setup:
    """Return what a laboratory knows of this world."""
    optics = description.optics
    return Setup(
        camera=CameraSetup(
            frame_rate_hz=frame_rate_hz,
            height_px=optics.rows,
            width_px=optics.columns,
            front_view_rows=optics.front_rows,
            top_view_rows=optics.top_rows,
            scale_px_per_m=optics.scale_px_per_m,
            front_origin_px=optics.front_origin_px,
            top_origin_px=optics.top_origin_px,
            exposure_s=optics.exposure_s,
        ),
        spheres=(
            SphereSetup("a", description.sphere_a.diameter_m),
            SphereSetup("b", description.sphere_b.diameter_m),
        ),
        environment=Environment(description.environment.gravity_m_per_s2),
    )


def picture(
    centre_a: Sequence[float],
    centre_b: Sequence[float] | None,
    markers_a: Floats,
    *,
    seed: int = 0,
) -> NDArray[np.uint8]:
    """Photograph sphere a with markers (directions in rig axes) and sphere b without."""
    spheres = (Sphere(), Sphere(markers=0))
    camera = Camera(OPTICS, spheres, (markers_a, np.empty((0, 3))))
    b = None if centre_b is None else Pose(np.array(centre_b), UPRIGHT)
    poses = (Pose(np.array(centre_a), UPRIGHT), b)
    return camera.take(lambda _: poses, 0.0, np.random.default_rng(seed))


def shot(pressure_kpa: float, offset_mm: float, *, seed: int = 3, frames: int = 20) -> RenderedShot:
    """Render one shot of the thesis's nylon rig."""
    launch = Launch(pressure_kpa, pressure_kpa, offset_mm * 1e-3)
    return render_shot(WorldDescription(), launch, seed, frames=frames)
