"""One plain sphere before the camera, without the mirror."""

from __future__ import annotations

import numpy as np

from simulators.world.description import Sphere
from simulators.world.optics import Optics
from simulators.world.render import Camera, Poses
from simulators.world.scene import NO_MIRROR_PX
from simulators.world.state import Pose

UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


def single_sphere_camera(diameter_m: float, diameter_px: float, *, exposure_s: float) -> Camera:
    """Return a camera before a plain sphere of this diameter, at the scale that makes it so large.

    Row 0 and column 0 of the frame are X = Y = 0.
    """
    optics = Optics(
        scale_px_per_m=diameter_px / diameter_m,
        front_origin_px=(0.0, 0.0),
        top_origin_px=NO_MIRROR_PX,
        exposure_s=exposure_s,
    )
    sphere = Sphere(diameter_m=diameter_m, markers=0)
    return Camera(optics, (sphere,), (np.empty((0, 3)),))


def standing(pose: Pose) -> Poses:
    """Return one sphere's pose at any time: it stands still."""
    return lambda _: (pose,)
