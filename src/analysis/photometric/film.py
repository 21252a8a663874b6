"""A shot being measured: its frames, its background and the poses found so far."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.photometric.appearance import Knowledge
from analysis.photometric.background import background_of
from analysis.photometric.camera import Camera, Optics, disc_of
from analysis.photometric.confirmation import confirmed
from analysis.photometric.pose import fit_pose
from analysis.photometric.sight import LIGHTS, Scene, Sight, Stance

Floats = NDArray[np.float64]

FAR = -1e6
MISFIT = 1.7
"""Growth of a frame's cost beyond which its pose is not believed."""


@dataclass(slots=True, eq=False)
class Film:
    """Frames of one shot with the poses of both spheres, improved in place.

    Attributes
    ----------
    frames
        Grey levels, shape (F, rows, columns).
    background, noise
        Grey levels, shape (rows, columns), and the standard deviation of a pixel.
    centre, rotation
        m and body to rig axes, shapes (2, F, 3), (2, F, 3, 3).
    lights
        Offset, gain and slopes of the light in each view, shape (2, F, V, LIGHTS).
    covariance
        Of centre and turn, shape (2, F, 6, 6).
    quality
        What `fit_pose` returns, shape (2, F, 5).
    placed
        Frames that have a pose, shape (2, F).
    """

    frames: NDArray[np.uint8]
    background: Floats
    noise: float
    centre: Floats
    rotation: Floats
    lights: Floats
    covariance: Floats
    quality: Floats
    placed: NDArray[np.bool_]

    @classmethod
    def blank(cls, frames: NDArray[np.uint8], views: int) -> Film:
        """Return a film without poses."""
        count = len(frames)
        lights = np.zeros((2, count, views, LIGHTS))
        lights[..., 1] = 1.0
        return cls(
            frames=np.ascontiguousarray(frames),
            background=np.zeros(frames.shape[1:]),
            noise=1.0,
            centre=np.zeros((2, count, 3)),
            rotation=np.tile(np.eye(3), (2, count, 1, 1)),
            lights=lights,
            covariance=np.zeros((2, count, 6, 6)),
            quality=np.zeros((2, count, 5)),
            placed=np.zeros((2, count), dtype=np.bool_),
        )

    def refresh(self, known: Knowledge) -> None:
        """Take background and noise from the pixels that no disc comes near."""
        radii = (known.spheres[0].radius_m, known.spheres[1].radius_m)
        self.background, self.noise = background_of(self.frames, self.discs(known.camera, radii))

    def rescale(self, old: Optics, scales: Floats) -> None:
        """Move the centres so that the discs stay where they are at other scales, px/m (V,).

        The front view places X and Y, the last view Z.
        """
        change = old.scales / scales
        self.centre *= np.array([change[0], change[0], change[-1]])

    def discs(self, camera: Camera, radii_m: tuple[float, float]) -> Floats:
        """Return all discs of all frames, shape (F, 2 V, 3); far away where there is no pose."""
        return np.stack([self.discs_of(k, camera, radii_m) for k in range(len(self.frames))])

    def discs_of(self, frame: int, camera: Camera, radii_m: tuple[float, float]) -> Floats:
        """Return all discs of one frame (row, column, radius), shape (2 V, 3)."""
        views = len(camera.views)
        discs = np.full((2 * views, 3), FAR)
        discs[:, 2] = 0.0
        for i in (0, 1):
            if self.placed[i, frame]:
                for view in range(views):
                    discs[views * i + view] = disc_of(
                        camera.optics, view, self.centre[i, frame], radii_m[i]
                    )
        return discs

    def sights(self, known: Knowledge, sphere: int) -> Iterator[tuple[Sight, Stance]]:
        """Yield each frame that has a pose of a sphere, with that pose to be read or improved."""
        radii = (known.spheres[0].radius_m, known.spheres[1].radius_m)
        discs = self.discs(known.camera, radii)
        look = known.looks()[sphere]
        for k in np.flatnonzero(self.placed[sphere]):
            yield (
                Sight(
                    Scene(self.frames[k], self.background, self.noise),
                    known.camera.optics,
                    look,
                    others_of(discs[k], sphere),
                ),
                Stance(self.centre[sphere, k], self.rotation[sphere, k], self.lights[sphere, k]),
            )


def sights_of(
    films: Sequence[Film], known: Knowledge, sphere: int
) -> Iterator[tuple[Sight, Stance]]:
    """Yield the sights of a sphere in all films."""
    for film in films:
        yield from film.sights(known, sphere)


def others_of(discs: Floats, sphere: int) -> Floats:
    """Return for each view of a sphere the other discs of a frame, shape (V, 2 V - 1, 3)."""
    views = len(discs) // 2
    own = [views * sphere + view for view in range(views)]
    return np.stack([np.delete(discs, disc, axis=0) for disc in own])


def fit_film(film: Film, known: Knowledge, limits: Floats) -> None:
    """Improve every pose of a film, one step for each limit (`pose.fit_pose`)."""
    for i in (0, 1):
        frames = np.flatnonzero(film.placed[i])
        for k, (sight, stance) in zip(frames, film.sights(known, i), strict=True):
            film.quality[i, k] = fit_pose(sight, stance, limits, film.covariance[i, k])


def drop_outside(film: Film, camera: Camera) -> None:
    """Take away poses whose centre lies outside the frame in the front view."""
    rows, columns = film.frames.shape[1:]
    optics = camera.optics
    place = film.centre @ optics.axes[0, :2].T * optics.scales[0] + optics.origins[0]
    inside = (place >= -0.5).all(axis=2) & (place <= [rows - 0.5, columns - 0.5]).all(axis=2)
    film.placed &= inside


def cost_of(quality: Floats, limit: float) -> Floats:
    """Return chi-squared a pixel, those rejected counted as far as the limit allows.

    Parameters
    ----------
    quality
        What `fit_pose` returned, shape (..., 5).
    limit
        Its last limit, in units of the noise.
    """
    rejected = limit**2 / 4 * (quality[..., 2] - quality[..., 1])
    return np.asarray((quality[..., 0] + rejected) / np.maximum(quality[..., 2], 1.0))


def drop_misfits(film: Film, known: Knowledge, limit: float) -> None:
    """Take away poses that are not to be believed.

    Those whose image the model explains much worse than the sphere's other frames, and those
    whose markers are not there.
    """
    costs = cost_of(film.quality, limit)
    for i in (0, 1):
        if not film.placed[i].any():
            continue
        frames = np.flatnonzero(film.placed[i])
        there = [confirmed(sight, stance) for sight, stance in film.sights(known, i)]
        sound = costs[i, frames] < MISFIT * np.median(costs[i, frames])
        film.placed[i, frames] = sound & np.array(there)
