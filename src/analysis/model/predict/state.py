"""What each shot happened to be: the 24 numbers that the campaign's model does not predict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.operator import States
from analysis.model.loops import plain
from analysis.model.loops.sides import tangents
from analysis.motion.rotation import rotation_matrix

SIZE = 24
TIME, POINT, TILT, MOTION, TURN_A, TURN_B = (
    slice(0, 1),
    slice(1, 4),
    slice(4, 6),
    slice(6, 18),
    slice(18, 21),
    slice(21, 24),
)
"""Where the numbers stand in a step: contact time (s), point of contact (m), tilt of the normal
(rad, along its two tangents), velocities of a and b and spins of a and b just before contact
(m/s, rad/s), rotations of both orientations at contact (rad, rig axes)."""


KICK_NUMBERS = 2
"""Of a kick, across the normal, that a shot determines."""


@dataclass(frozen=True, slots=True, eq=False)
class Kick:
    """An impulse across the normal beyond what the law gives, in shots without a known spin.

    Attributes
    ----------
    change
        Of the relative velocity, m/s, shape (S, 3); what of it lies along the normal has no effect.
    unknown
        Which spheres' spins are not known, shape (S, 2). Among the 24 numbers the kick stands in
        the place of the first of them.
    """

    change: Floats
    unknown: NDArray[np.bool_]

    @property
    def shots(self) -> NDArray[np.intp]:
        """Shots that have one, shape (K,)."""
        return np.flatnonzero(self.unknown.any(axis=1))

    @property
    def sphere(self) -> NDArray[np.intp]:
        """In the place of whose spin it stands in each of these shots, shape (K,)."""
        return np.asarray(self.unknown[self.shots].argmax(axis=1))

    def taken(self, motion: Floats, normal: Floats) -> tuple[Kick, Floats]:
        """Take the kick out of a step of velocities and spins (S, 4, 3), and hold unknown spins.

        What the step has along the new normal (S, 3) is dropped: nothing determines it, and with
        the next tilt it would be felt.
        """
        rows, slots = self.shots, 2 + self.sphere
        change, motion = self.change.copy(), motion.copy()
        change[rows] += motion[rows, slots]
        change -= (change * normal).sum(axis=1, keepdims=True) * normal
        motion[rows, slots] = 0.0
        return Kick(change, self.unknown), motion

    @classmethod
    def none(cls, shots: int) -> Kick:
        """Return that of shots whose spins are all known."""
        return cls(np.zeros((shots, 3)), np.zeros((shots, 2), dtype=np.bool_))

    @classmethod
    def joined(cls, parts: Sequence[Kick]) -> Kick:
        """Return those of shots that follow each other in parts."""
        return cls(
            np.concatenate([p.change for p in parts]), np.concatenate([p.unknown for p in parts])
        )

    def picked(self, rows: NDArray[np.bool_] | slice) -> Kick:
        """Return that of some shots."""
        return Kick(self.change[rows], self.unknown[rows])


@dataclass(frozen=True, slots=True, eq=False)
class ShotStates:
    """State of every shot at first touch, S shots.

    Attributes
    ----------
    time_s
        First touch, s from the shot's first frame, shape (S,).
    point
        Point of contact, m, shape (S, 3).
    normal
        Unit vector from a to b, shape (S, 3).
    before
        Velocities and spins just before contact.
    rotation
        Orientations at contact, body to rig axes, shape (S, 2, 3, 3).
    kick
        Where spins are not known; None: they are, in every shot.
    """

    time_s: Floats
    point: Floats
    normal: Floats
    before: States
    rotation: Floats
    kick: Kick | None = None

    def tangents(self) -> tuple[Floats, Floats]:
        """Return two unit vectors across each normal and each other, shape (S, 3)."""
        return tangents(plain(self.normal))

    def moved(self, step: Floats) -> ShotStates:
        """Return the states a step further, shape (S, 24)."""
        first, second = self.tangents()
        normal = self.normal + step[:, 4:5] * first + step[:, 5:6] * second
        motion, kick = step[:, MOTION].reshape(-1, 4, 3), self.kick
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        if kick is not None:
            kick, motion = kick.taken(motion, normal)
        turns = np.stack([step[:, TURN_A], step[:, TURN_B]], axis=1)
        return ShotStates(
            time_s=self.time_s + step[:, 0],
            point=self.point + step[:, POINT],
            normal=normal,
            before=States(
                velocity_a=self.before.velocity_a + motion[:, 0],
                velocity_b=self.before.velocity_b + motion[:, 1],
                spin_a=self.before.spin_a + motion[:, 2],
                spin_b=self.before.spin_b + motion[:, 3],
            ),
            rotation=rotation_matrix(turns) @ self.rotation,
            kick=kick,
        )

    def chosen(self, new: ShotStates, take: NDArray[np.bool_]) -> ShotStates:
        """Return the new state where `take` (S,) is true and the present one elsewhere."""

        def pick(old: Floats, other: Floats) -> Floats:
            mask = take.reshape(-1, *([1] * (old.ndim - 1)))
            return np.where(mask, other, old)

        names = ("velocity_a", "velocity_b", "spin_a", "spin_b")
        return ShotStates(
            time_s=pick(self.time_s, new.time_s),
            point=pick(self.point, new.point),
            normal=pick(self.normal, new.normal),
            before=States(*(pick(getattr(self.before, n), getattr(new.before, n)) for n in names)),
            rotation=pick(self.rotation, new.rotation),
            kick=None
            if self.kick is None or new.kick is None
            else Kick(pick(self.kick.change, new.kick.change), self.kick.unknown),
        )

    def replaced(self, where: NDArray[np.bool_], new: ShotStates) -> ShotStates:
        """Return the states with those of some shots, mask of shape (S,), replaced by new ones."""

        def put(old: Floats, other: Floats) -> Floats:
            whole = old.copy()
            whole[where] = other
            return whole

        motion = ("velocity_a", "velocity_b", "spin_a", "spin_b")
        kick = self.kick
        if kick is not None and new.kick is not None:
            kick = Kick(put(kick.change, new.kick.change), kick.unknown)
        return ShotStates(
            time_s=put(self.time_s, new.time_s),
            point=put(self.point, new.point),
            normal=put(self.normal, new.normal),
            before=States(*(put(getattr(self.before, n), getattr(new.before, n)) for n in motion)),
            rotation=put(self.rotation, new.rotation),
            kick=kick,
        )

    def of_shots(self, chosen: NDArray[np.bool_] | slice) -> ShotStates:
        """Return the states of some shots, mask of shape (S,) or a slice."""
        before = self.before
        return ShotStates(
            time_s=self.time_s[chosen],
            point=self.point[chosen],
            normal=self.normal[chosen],
            before=States(
                before.velocity_a[chosen],
                before.velocity_b[chosen],
                before.spin_a[chosen],
                before.spin_b[chosen],
            ),
            rotation=self.rotation[chosen],
            kick=None if self.kick is None else self.kick.picked(chosen),
        )

    @property
    def count(self) -> int:
        """Number of shots."""
        return len(self.time_s)

    def part(self, some: slice) -> ShotStates:
        """Return the states of successive shots, without copying."""
        return self.of_shots(some)

    @classmethod
    def joined(cls, parts: Sequence[ShotStates]) -> ShotStates:
        """Return the states of shots that follow each other in parts."""
        if len(parts) == 1:
            return parts[0]
        motion = ("velocity_a", "velocity_b", "spin_a", "spin_b")
        kicked = any(p.kick is not None for p in parts)
        kicks = [Kick.none(p.count) if p.kick is None else p.kick for p in parts]
        return cls(
            time_s=np.concatenate([p.time_s for p in parts]),
            point=np.concatenate([p.point for p in parts]),
            normal=np.concatenate([p.normal for p in parts]),
            before=States(*(np.concatenate([getattr(p.before, n) for p in parts]) for n in motion)),
            rotation=np.concatenate([p.rotation for p in parts]),
            kick=Kick.joined(kicks) if kicked else None,
        )
