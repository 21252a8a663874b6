"""A first guess of every shot's state, from the shot alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.operator import States
from analysis.model.data.poses import PoseData
from analysis.model.data.tables import ContactTable, Data
from analysis.model.data.unseen import spins_unknown
from analysis.model.predict.state import Kick, ShotStates
from analysis.motion.rotation import rotation_matrix, rotation_vector

LEAST_FRAMES, LEAST_FOR_A_LINE = 3, 2
BESIDE = 8
"""Frames on either side of a bounce that say when it was."""


def first_states(data: Data) -> ShotStates:
    """Guess the states by straight lines before and after the kink of the tracks.

    For every split straight lines through both spheres, gravity taken out; the smallest sum of
    squares wins. The instant is where the lines before touch, kept within a frame of the split;
    spins are medians of the turns from frame to frame, which one slipped orientation cannot move.
    Tabulated contacts say themselves what was before; where and when are then of no account.
    """
    if isinstance(data, ContactTable):
        return _tabulated(data)
    seen, straight = data.seen, _straightened(data)
    if data.on_plate:
        before, after = _beside_bounce(data.times_s, seen)
        seen = before | after
    else:
        split = _splits(data.times_s, straight.reshape(*seen.shape, 6), seen)
        before = seen & (np.arange(seen.shape[1]) < split[:, None])
    place, slope = _lines(data.times_s, straight.reshape(*seen.shape, 6), before)
    place, slope = place.reshape(-1, 2, 3), slope.reshape(-1, 2, 3)
    reach = sum(body.radius for body in data.bodies)
    bounds = _bounds(data.times_s, before, seen)
    if data.on_plate:
        time = _kink(data, (before, after), bounds)[0]
    else:
        time = _touch(place, slope, reach, bounds)
    centres = place + slope * time[:, None, None]
    centres[..., 0] += (0.5 * data.gravity * time**2)[:, None]
    slope = slope.copy()
    slope[..., 0] += (data.gravity * time)[:, None]
    if data.on_plate:
        centres[:, 1] = centres[:, 0] + reach * np.array(data.plate.normal)
        slope[:, 1] = 0.0
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
        kick=_kick(data),
    )


def first_restitutions(data: PoseData) -> Floats:
    """Guess e of every bounce on a plate by straight lines next to it, gravity taken out, (S,)."""
    sides = before, after = _beside_bounce(data.times_s, data.seen)
    time, coming, leaving = _kink(data, sides, _bounds(data.times_s, before, before | after))
    falling = data.gravity * time * data.plate.normal[0]
    return np.asarray(-(leaving + falling) / np.maximum(coming + falling, 1e-9))


def _straightened(data: PoseData) -> Floats:
    """Return places with the fall since time 0 taken out, 0 where not seen, (S, F, 2, 3)."""
    straight = data.position.copy()
    straight[..., 0] -= (0.5 * data.gravity * data.times_s**2)[..., None]
    return np.where(data.seen[..., None, None], straight, 0.0)


def _tabulated(table: ContactTable) -> ShotStates:
    shots = len(table.shots)
    return ShotStates(
        time_s=np.zeros(shots),
        point=np.zeros((shots, 3)),
        normal=table.normal,
        before=table.start,
        rotation=np.tile(np.eye(3), (shots, 2, 1, 1)),
        kick=_kick(table),
    )


def _kick(data: Data) -> Kick | None:
    unknown = spins_unknown(data)
    return Kick(np.zeros((len(unknown), 3)), unknown) if unknown.any() else None


def _beside_bounce(
    times: Floats, seen: NDArray[np.bool_]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return the frames next to a bounce, before and after it, shape (S, F).

    The lowest, from which time counts, may lie on either side and is in neither. Farther out the
    air bends the flights.
    """
    before, after = seen & (times < 0.0), seen & (times > 0.0)
    left = np.flip(np.cumsum(np.flip(before, axis=1), axis=1), axis=1)
    return before & (left <= BESIDE), after & (np.cumsum(after, axis=1) <= BESIDE)


def _splits(times: Floats, values: Floats, seen: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return for each shot the first frame after the best split, shape (S,)."""
    total = np.cumsum(_moments(times, values, seen), axis=1)
    early = np.zeros_like(total)
    early[:, 1:] = total[:, :-1]
    late = total[:, -1:] - early
    fewer = np.minimum(early[..., 0], late[..., 0])
    # Where no split leaves as many on both sides, two frames make a line.
    least = np.where(fewer.max(axis=1) >= LEAST_FRAMES, LEAST_FRAMES, LEAST_FOR_A_LINE)
    costs = np.where(fewer >= least[:, None], _misfit(early) + _misfit(late), np.inf)
    return np.asarray(costs.argmin(axis=1))


def _moments(times: Floats, values: Floats, seen: NDArray[np.bool_]) -> Floats:
    """Return 1, t, t^2, sum y^2, y and t y of every frame about the shot's middle, (S, F, 4 + 2 C).

    Zero where a sphere was not seen.
    """
    count = np.maximum(seen.sum(axis=1), 1)[:, None]
    t = times - (times * seen).sum(axis=1, keepdims=True) / count
    y = values - ((values * seen[..., None]).sum(axis=1) / count)[:, None]
    whole = [np.ones_like(t), t, t**2, (y**2).sum(axis=2)]
    moments = np.concatenate([np.stack(whole, axis=2), y, t[..., None] * y], axis=2)
    return np.asarray(moments * seen[..., None])


def _misfit(sums: Floats) -> Floats:
    """Return the sum of squares about straight lines from summed moments, (S, F, M) to (S, F)."""
    channels = (sums.shape[2] - 4) // 2
    count = np.maximum(sums[..., 0], 1.0)
    spread = np.maximum(sums[..., 2] - sums[..., 1] ** 2 / count, 1e-30)
    y, ty = sums[..., 4 : 4 + channels], sums[..., 4 + channels :]
    cross = ty - sums[..., 1, None] * y / count[..., None]
    left = (y**2).sum(axis=2) / count + (cross**2).sum(axis=2) / spread
    return np.asarray(sums[..., 3] - left)


def _lines(times: Floats, values: Floats, mask: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Return value at time 0 and slope of the straight line through the masked frames, (S, C)."""
    count = np.maximum(mask.sum(axis=1), 1)[:, None]
    middle = (times * mask).sum(axis=1, keepdims=True) / count
    mean = (values * mask[..., None]).sum(axis=1) / count
    offset = np.where(mask, times - middle, 0.0)
    spread = np.maximum((offset**2).sum(axis=1), 1e-30)[:, None]
    slope = (offset[..., None] * values).sum(axis=1) / spread
    return mean - slope * middle, slope


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


def _kink(
    data: PoseData,
    sides: tuple[NDArray[np.bool_], NDArray[np.bool_]],
    bounds: tuple[Floats, Floats],
) -> tuple[Floats, Floats, Floats]:
    """Return when lines before and after a bounce cross, within the bounds, and their slopes, (S,).

    Slopes are along the plate's normal, the fall taken out.
    """
    inward, centre = np.array(data.plate.normal), _straightened(data)[:, :, 0]
    (place, coming), (later, leaving) = (
        (value @ inward, slope @ inward)
        for value, slope in (_lines(data.times_s, centre, side) for side in sides)
    )
    closing = np.maximum(coming - leaving, 1e-9)
    return np.asarray(np.clip((later - place) / closing, *bounds)), coming, leaving


def _turning(data: PoseData, before: NDArray[np.bool_], time: Floats) -> tuple[Floats, Floats]:
    """Return spins before contact (S, 2, 3) and orientations at contact (S, 2, 3, 3).

    Orientations are carried on from the last one before contact, or back from the first there is.
    """
    measured = np.isfinite(data.rotation_sigma)
    early = measured & before[..., None]
    spin = median_spin(data, early)
    last = early.shape[1] - 1 - np.flip(early, axis=1).argmax(axis=1)
    nearest = np.where(early.any(axis=1), last, measured.argmax(axis=1))
    rows = np.arange(len(time))[:, None]
    turned = data.rotation[rows, nearest, np.arange(2)]
    ahead = rotation_matrix(spin * (time[:, None] - data.times_s[rows, nearest])[..., None])
    known = np.asarray(measured.any(axis=1))
    return spin, np.where(known[..., None, None], ahead @ turned, np.eye(3))


def median_spin(data: PoseData, early: NDArray[np.bool_]) -> Floats:
    """Return the median turn between successive measured frames over the time between, (S, 2, 3).

    Zero where fewer than two frames tell.
    """
    frames = np.arange(early.shape[1])[:, None]
    previous = np.maximum.accumulate(np.where(early, frames, -1), axis=1)[:, :-1]
    pair = early[:, 1:] & (previous >= 0)
    rows, at = np.arange(len(early))[:, None, None], np.maximum(previous, 0)
    earlier = data.rotation[rows, at, np.arange(2)]
    turned = rotation_vector(data.rotation[:, 1:] @ np.swapaxes(earlier, -1, -2))
    passed = data.times_s[:, 1:, None] - data.times_s[rows, at]
    rate = turned / np.where(pair, passed, np.inf)[..., None]
    ordered = np.sort(np.where(pair[..., None], rate, np.inf), axis=1)
    count = pair.sum(axis=1)
    low, high = np.maximum((count - 1) // 2, 0), np.minimum(count // 2, pair.shape[1] - 1)
    spheres = np.arange(2)
    middle = 0.5 * (ordered[rows[:, 0], low, spheres] + ordered[rows[:, 0], high, spheres])
    return np.where(count[..., None] > 0, middle, 0.0)
