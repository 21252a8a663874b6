"""A first guess of every shot's state, from the shot alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.collision.operator import States
from analysis.model.poses import PoseData
from analysis.model.state import ShotStates
from analysis.motion.rotation import rotation_matrix, rotation_vector

Floats = NDArray[np.float64]

LEAST_FRAMES = 3


def first_states(data: PoseData) -> ShotStates:
    """Guess the states by straight lines before and after the kink of the tracks.

    For every split straight lines through both spheres, gravity taken out; the smallest sum of
    squares wins. The instant is where the lines before touch, kept within a frame of the split;
    spins are medians of the turns from frame to frame, which one slipped orientation cannot move.
    """
    seen = np.asarray(np.isfinite(data.position_sigma).all(axis=(2, 3)))
    fall = 0.5 * data.gravity * data.times_s**2
    straight = data.position.copy()
    straight[..., 0] -= fall[..., None]
    straight = np.where(seen[..., None, None], straight, 0.0)
    split = _splits(data.times_s, straight.reshape(*seen.shape, 6), seen)
    before = seen & (np.arange(seen.shape[1]) < split[:, None])
    place, slope = _lines(data.times_s, straight.reshape(*seen.shape, 6), before)
    place, slope = place.reshape(-1, 2, 3), slope.reshape(-1, 2, 3)
    reach = sum(body.radius for body in data.bodies)
    time = _touch(place, slope, reach, _bounds(data.times_s, before, seen))
    centres = place + slope * time[:, None, None]
    centres[..., 0] += (0.5 * data.gravity * time**2)[:, None]
    slope = slope.copy()
    slope[..., 0] += (data.gravity * time)[:, None]
    normal = centres[:, 1] - centres[:, 0]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    share = data.bodies[0].radius / reach
    spin, rotation = _turning(data, before, time)
    return ShotStates(
        time_s=time,
        point=(1 - share) * centres[:, 0] + share * centres[:, 1],
        normal=normal,
        before=States(slope[:, 0], slope[:, 1], spin[:, 0], spin[:, 1]),
        rotation=rotation,
    )


def _splits(times: Floats, values: Floats, seen: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return for each shot the first frame after the best split, shape (S,)."""
    costs = np.full(seen.shape, np.inf)
    for split in range(LEAST_FRAMES, seen.shape[1] - LEAST_FRAMES + 1):
        early = seen & (np.arange(seen.shape[1]) < split)
        late = seen & ~early
        enough = (early.sum(axis=1) >= LEAST_FRAMES) & (late.sum(axis=1) >= LEAST_FRAMES)
        total = _misfit(times, values, early) + _misfit(times, values, late)
        costs[:, split] = np.where(enough, total, np.inf)
    return np.asarray(costs.argmin(axis=1))


def _lines(times: Floats, values: Floats, mask: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Return value at time 0 and slope of the straight line through the masked frames, (S, C)."""
    count = np.maximum(mask.sum(axis=1), 1)[:, None]
    middle = (times * mask).sum(axis=1, keepdims=True) / count
    mean = (values * mask[..., None]).sum(axis=1) / count
    offset = np.where(mask, times - middle, 0.0)
    spread = np.maximum((offset**2).sum(axis=1), 1e-30)[:, None]
    slope = (offset[..., None] * values).sum(axis=1) / spread
    return mean - slope * middle, slope


def _misfit(times: Floats, values: Floats, mask: NDArray[np.bool_]) -> Floats:
    place, slope = _lines(times, values, mask)
    residual = values - place[:, None] - slope[:, None] * times[..., None]
    return np.asarray((mask[..., None] * residual**2).sum(axis=(1, 2)))


def _bounds(
    times: Floats, before: NDArray[np.bool_], seen: NDArray[np.bool_]
) -> tuple[Floats, Floats]:
    after = seen & ~before
    last = np.where(before, times, -np.inf).max(axis=1)
    first = np.where(after, times, np.inf).min(axis=1)
    frame = np.maximum(first - last, 1e-6)
    return last - frame, first + frame


def _touch(place: Floats, slope: Floats, reach: float, bounds: tuple[Floats, Floats]) -> Floats:
    """Return when the lines touch, or are nearest where they do not, within the bounds."""
    gap, speed = place[:, 1] - place[:, 0], slope[:, 1] - slope[:, 0]
    a = np.maximum((speed**2).sum(axis=1), 1e-12)
    b = (gap * speed).sum(axis=1)
    c = (gap**2).sum(axis=1) - reach**2
    root = np.sqrt(np.maximum(b**2 - a * c, 0.0))
    return np.asarray(np.clip((-b - root) / a, *bounds))


def _turning(data: PoseData, before: NDArray[np.bool_], time: Floats) -> tuple[Floats, Floats]:
    """Return spins before contact (S, 2, 3) and orientations at contact (S, 2, 3, 3)."""
    shots = len(time)
    spin, rotation = np.zeros((shots, 2, 3)), np.tile(np.eye(3), (shots, 2, 1, 1))
    measured = np.isfinite(data.rotation_sigma)
    for s in range(shots):
        for i in (0, 1):
            frames = np.flatnonzero(before[s] & measured[s, :, i])
            if frames.size == 0:
                frames = np.flatnonzero(measured[s, :, i])[:1]
            if frames.size == 0:
                continue
            turned, times = data.rotation[s, frames, i], data.times_s[s, frames]
            if frames.size > 1:
                steps = rotation_vector(turned[1:] @ np.swapaxes(turned[:-1], -1, -2))
                spin[s, i] = np.median(steps / np.diff(times)[:, None], axis=0)
            ahead = rotation_matrix(spin[s, i] * (time[s] - times[-1]))
            rotation[s, i] = ahead @ turned[-1]
    return spin, rotation
