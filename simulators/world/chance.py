"""Which random numbers belong to what, so that nothing shifts another thing's chance."""

from __future__ import annotations

import numpy as np

from simulators.world.description import WorldDescription
from simulators.world.markers import scatter_markers
from simulators.world.render import Camera

_MARKERS, _SHOT, _NOISE = range(3)


def marked_camera(description: WorldDescription, seed: int) -> Camera:
    """Return the camera, before it the two spheres with the markers that this seed scatters."""
    rng = np.random.default_rng([seed, _MARKERS])
    spheres = (description.sphere_a, description.sphere_b)
    return Camera(
        description.optics, spheres, [scatter_markers(sphere.markers, rng) for sphere in spheres]
    )


def shot_chance(seed: int, shot: int) -> np.random.Generator:
    """Return the scatter of one shot, by its number."""
    return np.random.default_rng([seed, _SHOT, shot])


def noise_chance(seed: int, time_s: float) -> np.random.Generator:
    """Return the noise of the picture at a time, the same for times within half a nanosecond."""
    nanoseconds = round(time_s * 1e9)
    return np.random.default_rng([seed, _NOISE, int(nanoseconds < 0), abs(nanoseconds)])
