"""A shot being measured: its frames, its background and the poses found so far."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Grey, Singles, as_singles
from analysis.photometric.follow.cast_shadows import mark_shadows
from analysis.photometric.follow.confirmation import confirmed
from analysis.photometric.learn.appearance import Appearance
from analysis.photometric.render.background import background_of
from analysis.photometric.render.camera import Optics, discs_of, keep_places
from analysis.photometric.render.pose import fit_frames
from analysis.photometric.render.sight import LIGHTS, Reel, Scene, Sight, Stance
from analysis.photometric.render.smear import (
    LEAST_SMEAR_PX,
    longest_smear,
    motion_through,
    round_variance,
)

ALL = slice(None)
MOST_STEPS, STILL = 4, 1e-3
"""Steps of the last fit, and their length in radii and radians from which another follows."""
MOST_REJECTED = 0.07
"""Share of a pose's pixels with residuals beyond a limit of 6: 0.055 by noise alone, 0.06 to 0.08
in even light, 0.065 to 0.3 with shadows."""
LEFT_OF_SHADOWS = 0.33
"""Of what shadows moved a pose by, once they are taken out."""
MISFIT = 1.7
"""Growth of a frame's cost beyond which its pose is rejected."""


@dataclass(slots=True, eq=False)
class Film:
    """Frames of one shot with the poses of both spheres, improved in place.

    Attributes
    ----------
    frames
        Grey levels, shape (F, rows, columns).
    background, noise
        Grey levels, shape (rows, columns), and the standard deviation of a pixel.
    shadowed
        Pixels in shadows cast on a sphere, same shape as the frames.
    shadow_px
        What shadows may leave of error in the discs' places, pixels.
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
    motion
        What each sphere moves, m, and turns by, rad, while the shutter is open, shape (2, F, 6); 0
        where no exposure is stated.
    times_s, gravity
        Times of the frames, s, shape (F,), and gravity along +X, m/s^2, to predict spheres without
        a pose.
    left_out
        Frames of each sphere that show it and hold no reliable pose, with the reason.
    """

    frames: Singles
    background: Floats
    noise: float
    shadowed: NDArray[np.bool_]
    shadow_px: float
    centre: Floats
    rotation: Floats
    lights: Floats
    covariance: Floats
    quality: Floats
    placed: NDArray[np.bool_]
    motion: Floats
    times_s: Floats
    gravity: float
    left_out: tuple[dict[int, str], dict[int, str]]

    @classmethod
    def blank(cls, frames: Grey, views: int, times_s: Floats, gravity: float) -> Film:
        """Return a film without poses."""
        count = len(frames)
        lights = np.zeros((2, count, views, LIGHTS))
        lights[..., 1] = 1.0
        return cls(
            frames=as_singles(frames),
            background=np.zeros(frames.shape[1:]),
            noise=1.0,
            shadowed=np.zeros(frames.shape, dtype=np.bool_),
            shadow_px=0.0,
            centre=np.zeros((2, count, 3)),
            rotation=np.tile(np.eye(3), (2, count, 1, 1)),
            lights=lights,
            covariance=np.zeros((2, count, 6, 6)),
            quality=np.zeros((2, count, 5)),
            placed=np.zeros((2, count), dtype=np.bool_),
            motion=np.zeros((2, count, 6)),
            times_s=times_s,
            gravity=gravity,
            left_out=({}, {}),
        )

    def picked(self, most: int) -> Film:
        """Return a film of at most so many frames, spread over those that show both spheres."""
        both = np.flatnonzero(self.placed.all(axis=0))
        shown = both if len(both) else np.flatnonzero(self.placed.any(axis=0))
        few = shown[np.unique(np.linspace(0, len(shown) - 1, most).round().astype(np.intp))]
        part = replace(
            self, frames=self.frames[few], shadowed=self.shadowed[few], times_s=self.times_s[few]
        )
        for name in ("centre", "rotation", "lights", "covariance", "quality", "placed", "motion"):
            setattr(part, name, np.ascontiguousarray(getattr(self, name)[:, few]))
        return part

    def refresh(self, known: Appearance) -> None:
        """Take background and noise from the pixels that no disc comes near.

        Nor one of a sphere that has no pose there (`whereabouts`).
        """
        self.background, self.noise = background_of(self.frames, self.discs_anywhere(known))

    def leave_out(self, sphere: int, frames: NDArray[np.intp], reason: str) -> None:
        """Take the poses of a sphere from some frames, and keep in mind why."""
        self.placed[sphere, frames] = False
        self.left_out[sphere].update(dict.fromkeys(frames.tolist(), reason))

    def set_motion(self, known: Appearance, times_s: Floats, exposure_s: float | None) -> None:
        """Take what the spheres move by during an exposure from their poses, where one is stated.

        Poses fitted without it are good to hundredths of a pixel, and so is it. A film in which
        little is smeared stays as it is.
        """
        self.motion[:] = 0.0
        open_s = exposure_s or 0.0
        for i, placed in enumerate(self.placed if open_s > 0.0 else ()):
            frames = np.flatnonzero(placed)
            rates = np.zeros((len(frames), 6))
            centre, rotation = self.centre[i, frames], self.rotation[i, frames]
            motion_through(times_s[frames], centre, rotation, rates)
            self.motion[i, frames] = rates * open_s
        radius_m = max(sphere.radius_m for sphere in known.spheres)
        if longest_smear(known.camera.optics, self.motion, radius_m) < LEAST_SMEAR_PX:
            self.motion[:] = 0.0

    def keep_places(self, old: Optics, new: Optics) -> None:
        """Move the centres so that the discs stay where they are under another camera."""
        for centres in self.centre:
            keep_places(old, new, centres)

    def discs(self, known: Appearance, frames: slice = ALL) -> Floats:
        """Return all discs of the frames (row, column, radius), shape (F, 2 V, 3).

        Those of sphere a first; far away and without size where there is no pose.
        """
        radii = np.array([sphere.radius_m for sphere in known.spheres])
        centre = np.ascontiguousarray(self.centre[:, frames])
        placed = np.ascontiguousarray(self.placed[:, frames])
        return discs_of(known.camera.optics, centre, radii, placed)

    def discs_anywhere(self, known: Appearance) -> Floats:
        """Return `discs` with those of spheres that have no pose in a frame (`whereabouts`).

        As much larger as they may be elsewhere.
        """
        if self.placed.all():
            return self.discs(known)
        radii = np.array([sphere.radius_m for sphere in known.spheres])
        anywhere = self.placed | np.any(self.placed, axis=1, keepdims=True)
        there = [
            whereabouts(*own, self.times_s, self.gravity)
            for own in zip(self.centre, self.placed, strict=True)
        ]
        optics = known.camera.optics
        discs = discs_of(optics, np.stack([centres for centres, _ in there]), radii, anywhere)
        doubt = np.stack([own for _, own in there], axis=1)
        discs[..., 2] += np.repeat(doubt, len(optics.scales), axis=1) * optics.scales[0]
        return discs

    def reel(self, known: Appearance, sphere: int) -> Reel:
        """Return the frames with the poses of a sphere, to be read or improved."""
        return Reel(
            images=self.frames,
            background=self.background,
            noise=self.noise,
            shadowed=self.shadowed,
            optics=known.camera.optics,
            look=known.looks()[sphere],
            others=self._others(known, sphere),
            motion=self.motion[sphere],
            centre=self.centre[sphere],
            rotation=self.rotation[sphere],
            lights=self.lights[sphere],
            covariance=self.covariance[sphere],
            quality=self.quality[sphere],
        )

    def _others(self, known: Appearance, sphere: int) -> Floats:
        """Return `others_of` all frames, as wide as the other sphere's smear makes them."""
        discs = self.discs_anywhere(known)
        if self.motion.any():
            ways = np.linalg.norm(self.motion[:, :, :3], axis=2) / 2
            scales = known.camera.optics.scales
            discs[..., 2] += (ways[:, :, None] * scales).transpose(1, 0, 2).reshape(len(discs), -1)
        return others_of(discs, sphere)

    def sights(self, known: Appearance, sphere: int) -> Iterator[tuple[Sight, Stance]]:
        """Yield each frame that has a pose of a sphere, with that pose to be read or improved."""
        others, look = self._others(known, sphere), known.looks()[sphere]
        for k in np.flatnonzero(self.placed[sphere]):
            scene = Scene(self.frames[k], self.background, self.noise, self.shadowed[k])
            stance = Stance(
                self.centre[sphere, k], self.rotation[sphere, k], self.lights[sphere, k]
            )
            yield Sight(scene, known.camera.optics, look, others[k], self.motion[sphere, k]), stance


def sights_of(
    films: Sequence[Film], known: Appearance, sphere: int
) -> Iterator[tuple[Sight, Stance]]:
    """Yield the sights of a sphere in all films."""
    for film in films:
        yield from film.sights(known, sphere)


def round_smear(film: Film, known: Appearance) -> Floats:
    """Return `smear.round_variance` of all poses of a film."""
    return round_variance(known.camera.optics, film.motion[film.placed])


def others_of(discs: Floats, sphere: int) -> Floats:
    """Return for each view of a sphere the other discs of the same frame.

    Parameters
    ----------
    discs
        Shape (..., 2 V, 3).

    Returns
    -------
    Shape (..., V, 2 V - 1, 3).
    """
    return np.take(discs, _of_others(discs.shape[-2], sphere), axis=-2)


@lru_cache
def _of_others(count: int, sphere: int) -> NDArray[np.intp]:
    views = count // 2
    kept = [
        [disc for disc in range(count) if disc != views * sphere + view] for view in range(views)
    ]
    return np.array(kept, dtype=np.intp)


def fit_film(film: Film, known: Appearance, limits: Floats) -> None:
    """Improve every pose of a film, one step for each limit (`pose.fit_pose`)."""
    for i in (0, 1):
        fit_frames(film.reel(known, i), np.flatnonzero(film.placed[i]), limits)


def settle_film(film: Film, known: Appearance, limit: float) -> None:
    """Improve every pose of a film until it stays where it is.

    Poses that followed their frame well need one step; those beside a contact need more. Shadows
    found before are forgotten.
    """
    film.shadowed[:] = False
    _settle(film, known, limit, film.placed)


def settle_without_shadows(film: Film, known: Appearance, limit: float) -> None:
    """Take the shadows out of a film that has settled, and settle the frames that have any.

    The shift of the poses by shadows bounds what is left of it (`Film.shadow_px`).
    """
    before, doubtful = film.centre.copy(), film.placed & (_rejected(film) > MOST_REJECTED)
    take_out_shadows(film, known, doubtful)
    _settle(film, known, limit, film.placed & film.shadowed.any(axis=(1, 2)))
    moved = (film.centre - before)[film.placed] * float(known.camera.optics.scales[0])
    film.shadow_px = LEFT_OF_SHADOWS * float(np.sqrt((moved**2).mean())) if moved.size else 0.0


def _settle(film: Film, known: Appearance, limit: float, poses: NDArray[np.bool_]) -> None:
    for i in (0, 1):
        reel, frames = film.reel(known, i), np.flatnonzero(poses[i])
        for _ in range(MOST_STEPS):
            fit_frames(reel, frames, np.array([limit]))
            frames = frames[(film.quality[i, frames, 3:] > STILL).any(axis=1)]


def _rejected(film: Film) -> Floats:
    """Return the share of each pose's pixels that the last fit rejected, shape (2, F)."""
    looked_at = np.maximum(film.quality[..., 2], 1.0)
    return np.asarray((looked_at - film.quality[..., 1]) / looked_at)


def take_out_shadows(film: Film, known: Appearance, poses: NDArray[np.bool_] | None = None) -> None:
    """Find the shadows on the spheres of a film anew, in all poses or in some, shape (2, F)."""
    film.shadowed[:] = False
    for i, chosen in enumerate(film.placed if poses is None else poses):
        mark_shadows(film.reel(known, i), np.flatnonzero(chosen))


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


def drop_misfits(film: Film, known: Appearance, limit: float) -> None:
    """Remove poses that are not reliable.

    Those whose image the model explains much worse than the sphere's other frames, and those
    whose markers are not there.
    """
    costs = cost_of(film.quality, limit)
    for i in (0, 1):
        if not film.placed[i].any():
            continue
        frames = np.flatnonzero(film.placed[i])
        sound = costs[i, frames] < MISFIT * np.median(costs[i, frames])
        shown = confirmed(film.reel(known, i), frames)
        film.leave_out(i, frames[~sound], "it looks much less like the sphere than other frames do")
        film.leave_out(i, frames[sound & ~shown], "the markers are not where they should be")


LEAD = 8
"""Frames at the end of a track from which it is extrapolated."""
DOUBT_PER_S = 0.04
"""m/s by which a sphere may go on otherwise: 0.06 px a frame at a thousand frames a second."""
MOST_DOUBT_M = 0.004
DOWN = np.array([1.0, 0.0, 0.0])


def whereabouts(
    centres: Floats, placed: NDArray[np.bool_], times_s: Floats, gravity: float
) -> tuple[Floats, Floats]:
    """Carry a track on in free flight beyond its ends, and straight through its gaps.

    A sphere comes into the frame before its centre does, and one that has left the front view may
    pass through the mirror's for as long again. Taken for the scene behind the spheres, its picture
    moves objects before it by tenths of a pixel.

    Parameters
    ----------
    centres, placed
        m, rig axes, shape (F, 3), and which of them are known, shape (F,).
    times_s
        Shape (F,).
    gravity
        m/s^2 along +X.

    Returns
    -------
    Centres in all frames, m, shape (F, 3), and by how much they may be wrong, m, shape (F,). As
    they were given, and 0, where fewer than two are known.
    """
    known = np.flatnonzero(placed)
    doubt = np.zeros(len(times_s))
    if len(known) < 2:
        return centres, doubt
    whole = centres.copy()
    for axis in range(3):
        whole[:, axis] = np.interp(times_s, times_s[known], centres[known, axis])
    for end, own in ((known[0], known[:LEAD]), (known[-1], known[-LEAD:])):
        beyond = np.arange(len(times_s)) < end if end == known[0] else np.arange(len(times_s)) > end
        tau, ahead = times_s[own] - times_s[end], times_s[beyond] - times_s[end]
        straight = centres[own] - 0.5 * gravity * tau[:, None] ** 2 * DOWN
        spread = tau - tau.mean()
        velocity = spread @ straight / (spread @ spread)
        fallen = 0.5 * gravity * ahead[:, None] ** 2 * DOWN
        whole[beyond] = straight.mean(axis=0) + velocity * (ahead - tau.mean())[:, None] + fallen
        doubt[beyond] = np.minimum(DOUBT_PER_S * np.abs(ahead), MOST_DOUBT_M)
    return whole, doubt
