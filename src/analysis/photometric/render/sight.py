"""What compiled functions are given: a frame, a sphere's look, and where it is held to stand."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Singles
from analysis.compiled import part
from analysis.photometric.render.camera import Optics

LIGHTS = 4
"""Of a view in one frame: background offset, gain, slopes of the light along row and column."""


class Look(NamedTuple):
    """How a sphere looks.

    Attributes
    ----------
    radius_m
        Of the sphere.
    markers
        Directions in body axes, shape (markers, 3).
    alpha
        Angular radius of a marker, radians.
    darkness
        Share of the light that a marker swallows.
    discs
        Blurred disc of each view against the square of the distance, shape (V, steps).
    surfaces
        Light of the unmarked sphere in each view, shape (V, n, n) (`surface.draw_surface`).
    sigma_px
        Standard deviation of the blur in each view.
    """

    radius_m: float
    markers: Floats
    alpha: float
    darkness: float
    discs: Floats
    surfaces: Floats
    sigma_px: Floats


class Scene(NamedTuple):
    """One frame.

    Attributes
    ----------
    image
        Grey levels, shape (rows, columns).
    background
        Grey levels without spheres, same shape.
    noise
        Standard deviation of a pixel, grey levels.
    shadowed
        Pixels in shadows cast on a sphere (`cast_shadows`), which are left out of its pose, same
        shape.
    """

    image: Singles
    background: Floats
    noise: float
    shadowed: NDArray[np.bool_]


class Sight(NamedTuple):
    """One sphere in one frame: all that does not change while its pose is sought.

    Attributes
    ----------
    others
        For each view the other discs of the frame (row, column, radius), shape (V, others, 3).
    motion
        What the sphere moves, m, and turns by, rad, rig axes, while the shutter is open, shape
        (6,); 0 where that is not known.
    """

    scene: Scene
    optics: Optics
    look: Look
    others: Floats
    motion: Floats


class Stance(NamedTuple):
    """Where a sphere is held to stand.

    Attributes
    ----------
    centre
        m, rig axes, shape (3,).
    rotation
        Body to rig axes, shape (3, 3).
    lights
        Of each view, shape (V, LIGHTS).
    """

    centre: Floats
    rotation: Floats
    lights: Floats


class Equations(NamedTuple):
    """Normal equations under summation; only the lower triangle unless stated otherwise."""

    normal: Floats
    right: Floats


class Reel(NamedTuple):
    """Frames with the poses of one sphere, F of them.

    Attributes
    ----------
    images, background, noise, shadowed
        As in a Scene; images and shadows with shape (F, rows, columns).
    others, motion
        As in a Sight, shapes (F, V, others, 3) and (F, 6).
    centre, rotation, lights
        As in a Stance, shapes (F, 3), (F, 3, 3), (F, V, LIGHTS).
    covariance
        Of centre and turn, shape (F, 6, 6).
    quality
        Quality of each fit, shape (F, 5).
    """

    images: Singles
    background: Floats
    noise: float
    shadowed: NDArray[np.bool_]
    optics: Optics
    look: Look
    others: Floats
    motion: Floats
    centre: Floats
    rotation: Floats
    lights: Floats
    covariance: Floats
    quality: Floats


@part
def sight_at(reel: Reel, frame: int) -> tuple[Sight, Stance]:
    """Return a frame of a reel, with the pose in it to be read or improved."""
    scene = Scene(reel.images[frame], reel.background, reel.noise, reel.shadowed[frame])
    sight = Sight(scene, reel.optics, reel.look, reel.others[frame], reel.motion[frame])
    return sight, Stance(reel.centre[frame], reel.rotation[frame], reel.lights[frame])


def reel_of(sight: Sight, stance: Stance) -> Reel:
    """Return a reel of one frame that shares its arrays with the sight and the stance."""
    scene = sight.scene
    return Reel(
        images=scene.image[None],
        background=scene.background,
        noise=scene.noise,
        shadowed=scene.shadowed[None],
        optics=sight.optics,
        look=sight.look,
        others=sight.others[None],
        motion=sight.motion[None],
        centre=stance.centre[None],
        rotation=stance.rotation[None],
        lights=stance.lights[None],
        covariance=np.zeros((1, 6, 6)),
        quality=np.zeros((1, 5)),
    )
