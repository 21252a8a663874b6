"""From the mouths of the tubes to first touch and back: free flight, and its numbers.

A sphere that leaves its mouth at speed v falls for the way `mouth`; before that the push takes as
long as the way `push` at that speed. Spheres touch when their centres are a sum of radii apart.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.operator import Body, States
from analysis.launch.muzzle import ALONG, LaunchLaw, Muzzle
from analysis.model.predict.state import MOTION, POINT, TILT, ShotStates
from analysis.model.predict.state import SIZE as STATE_SIZE

VELOCITIES, SPINS, TOUCH_POINT, NORMAL = slice(0, 6), slice(6, 12), slice(12, 15), slice(15, 17)
"""Where the numbers of a touch stand in a row: velocities and spins of a and b, point of contact,
X and Z of the normal."""
_PASSES = 40
_LEAST_ALONG = 0.02
"""Least Y of the normal: tracks further apart than the spheres are thick are kept at a graze."""


@dataclass(frozen=True, slots=True)
class Ground:
    """What flight and touch need: spheres a and b, gravity along +X in m/s^2."""

    bodies: tuple[Body, Body]
    gravity: float

    @property
    def reach(self) -> float:
        """Distance of the centres at touch, m."""
        return self.bodies[0].radius + self.bodies[1].radius


def touch(muzzle: Muzzle, law: LaunchLaw, ground: Ground) -> Floats:
    """Return the state of both spheres at first touch, shape (S, 17): m/s, rad/s, m.

    The instant is the root of Y_b - Y_a = sqrt(D^2 - dX^2 - dZ^2), by iteration: the offsets
    change little in flight, so that each pass gains digits.
    """
    starts = np.stack([np.zeros_like(muzzle.lag_s), muzzle.lag_s], axis=1)
    starts = starts + law.push / muzzle.speed
    closing = muzzle.speed.sum(axis=1)
    time = (2 * law.mouth - ground.reach + (muzzle.speed * starts).sum(axis=1)) / closing
    for _ in range(_PASSES):
        centre = _centres(muzzle, law, ground, time[:, None] - starts)
        gap = centre[:, 1] - centre[:, 0]
        time = time + (gap[:, 1] - _along(gap, ground.reach)) / closing
    flown = time[:, None] - starts
    centre = _centres(muzzle, law, ground, flown)
    normal = (centre[:, 1] - centre[:, 0])[:, [0, 2]] / ground.reach
    share = ground.bodies[0].radius / ground.reach
    velocity = muzzle.speed[..., None] * np.stack(
        [muzzle.slope[..., 0], np.broadcast_to(ALONG, flown.shape), muzzle.slope[..., 1]], axis=-1
    )
    velocity[..., 0] += ground.gravity * flown
    return np.concatenate(
        [
            velocity.reshape(-1, 6),
            muzzle.spin.reshape(-1, 6),
            (1 - share) * centre[:, 0] + share * centre[:, 1],
            normal,
        ],
        axis=1,
    )


def traced_back(rows: Floats, law: LaunchLaw, ground: Ground) -> Muzzle:
    """Return the muzzles of touches (S, 17): `touch` the other way round, in closed form.

    The centres are followed back along their parabolas to the mouths.
    """
    along = rows[:, NORMAL]
    third = np.sqrt(np.maximum(1.0 - (along**2).sum(axis=1), _LEAST_ALONG**2))
    normal = np.stack([along[:, 0], third, along[:, 1]], axis=1)
    reach = np.array([-ground.bodies[0].radius, ground.bodies[1].radius])
    centre = rows[:, None, TOUCH_POINT] + reach[:, None] * normal[:, None]
    velocity = rows[:, VELOCITIES].reshape(-1, 2, 3)
    speed = velocity[..., 1] * ALONG
    way = (centre[..., 1] - law.middle) * ALONG + law.mouth
    flown = way / speed
    fall = np.array([ground.gravity, 0.0])
    sideways = velocity[..., [0, 2]] - fall * flown[..., None]
    mouth = centre[..., [0, 2]] - sideways * flown[..., None] - 0.5 * fall * flown[..., None] ** 2
    since = flown + law.push / speed
    return Muzzle(
        speed=speed,
        slope=sideways / speed[..., None],
        spin=rows[:, SPINS].reshape(-1, 2, 3),
        offset_m=mouth[:, 1] - mouth[:, 0],
        height_m=mouth.mean(axis=1),
        lag_s=since[:, 0] - since[:, 1],
    )


def tracks_meet(rows: Floats) -> NDArray[np.bool_]:
    """Return whether the spheres of each touch (S, 17) meet at all, with more than a graze."""
    return np.asarray((rows[:, NORMAL] ** 2).sum(axis=1) < 1.0 - _LEAST_ALONG**2)


def _centres(muzzle: Muzzle, law: LaunchLaw, ground: Ground, flown: Floats) -> Floats:
    """Return centres a time after the mouths, shape (S, 2, 3)."""
    way = muzzle.speed * flown
    sides = np.array([-0.5, 0.5])
    across = muzzle.height_m[:, None] + sides[:, None] * muzzle.offset_m[:, None]
    across = across + muzzle.slope * way[..., None]
    down = across[..., 0] + 0.5 * ground.gravity * flown**2
    return np.stack([down, law.middle + ALONG * (way - law.mouth), across[..., 1]], axis=-1)


def _along(gap: Floats, reach: float) -> Floats:
    across = (gap[:, [0, 2]] ** 2).sum(axis=1)
    return np.asarray(np.sqrt(np.maximum(reach**2 - across, (_LEAST_ALONG * reach) ** 2)))


def observed_touch(states: ShotStates) -> Floats:
    """Return the fitted states of shots in the same numbers, shape (S, 17)."""
    before = states.before
    return np.concatenate(
        [
            before.velocity_a,
            before.velocity_b,
            before.spin_a,
            before.spin_b,
            states.point,
            states.normal[:, [0, 2]],
        ],
        axis=1,
    )


def touch_by_state(states: ShotStates) -> Floats:
    """Differentiate the numbers of a touch by the 24 of `model.state`, shape (S, 17, 24)."""
    derivative = np.zeros((len(states.time_s), 17, STATE_SIZE))
    derivative[:, :12, MOTION] = np.eye(12)
    derivative[:, TOUCH_POINT, POINT] = np.eye(3)
    derivative[:, NORMAL, TILT] = np.stack(states.tangents(), axis=-1)[:, [0, 2]]
    return derivative


def states_of(rows: Floats, time_s: Floats) -> ShotStates:
    """Return touches (S, 17) as states at the given times (S,), orientations unturned.

    The tracks must meet (`tracks_meet`).
    """
    normal = np.zeros((len(rows), 3))
    normal[:, [0, 2]] = rows[:, NORMAL]
    normal[:, 1] = np.sqrt(1.0 - (rows[:, NORMAL] ** 2).sum(axis=1))
    motion = [rows[:, 3 * k : 3 * k + 3] for k in range(4)]
    return ShotStates(
        time_s=time_s,
        point=rows[:, TOUCH_POINT],
        normal=normal,
        before=States(*motion),
        rotation=np.tile(np.eye(3), (len(rows), 2, 1, 1)),
    )
