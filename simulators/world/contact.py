"""The contact of two spheres, integrated in time from first touch to separation."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from simulators.world.description import ContactLaw, Sphere
from simulators.world.force import PairLaw, Vector
from simulators.world.rotation import turn
from simulators.world.state import Motion, Pose

_STEPS_PER_CONTACT = 600
_LONGEST_CONTACT = 4.0
_KEEP_EVERY = 10


@dataclass(frozen=True, slots=True)
class Contact:
    """One contact, from first touch to separation.

    Parameters
    ----------
    times_s
        (N,), the first is the first touch, the last the separation.
    motions
        N pairs: the motion of a and of b at each time.
    normal, normal_after
        Unit vectors (3,) from a to b at first touch and at separation.
    compression_m
        The largest overlap.
    """

    times_s: NDArray[np.float64]
    motions: tuple[tuple[Motion, Motion], ...]
    normal: NDArray[np.float64]
    normal_after: NDArray[np.float64]
    compression_m: float

    @property
    def start_s(self) -> float:
        """Time of the first touch."""
        return float(self.times_s[0])

    @property
    def end_s(self) -> float:
        """Time of the separation."""
        return float(self.times_s[-1])

    def pose(self, index: int, time_s: float) -> Pose:
        """Return the pose of a (0) or b (1) during the contact."""
        step = int(np.searchsorted(self.times_s, time_s, side="right")) - 1
        motion, since = self.motions[step][index], time_s - self.times_s[step]
        return Pose(
            motion.centre + motion.velocity * since,
            turn(motion.spin * since, motion.orientation),
        )


@dataclass(frozen=True, slots=True)
class Touch:
    """Two spheres at the instant they first touch.

    `outer` are the accelerations (3,) in m/s^2 by everything but the contact, which are taken as
    constant while it lasts.
    """

    time_s: float
    spheres: tuple[Sphere, Sphere]
    motions: tuple[Motion, Motion]
    outer: tuple[Vector, Vector]

    def apart(self, state: NDArray[np.float64], since: float) -> tuple[Motion, Motion]:
        """Return both motions from the relative state `since` seconds after the touch.

        The centre of mass moves as if untouched. Orientations are those at the touch.
        """
        a, b = self.motions
        mass_a, mass_b = (sphere.mass_kg for sphere in self.spheres)
        share_a, share_b = mass_a / (mass_a + mass_b), mass_b / (mass_a + mass_b)
        pull = share_a * self.outer[0] + share_b * self.outer[1]
        velocity = share_a * a.velocity + share_b * b.velocity
        centre = share_a * a.centre + share_b * b.centre + velocity * since + 0.5 * pull * since**2
        velocity = velocity + pull * since
        between, relative, spin_a, spin_b, _ = state
        return (
            Motion(
                centre - share_b * between, velocity - share_b * relative, a.orientation, spin_a
            ),
            Motion(
                centre + share_a * between, velocity + share_a * relative, b.orientation, spin_b
            ),
        )


def collide(touch: Touch, law: ContactLaw, steps: int = _STEPS_PER_CONTACT) -> Contact:
    """Integrate the contact of two touching spheres until they part.

    Midpoint rule with steps of 1/`steps` of Hertz's duration; the tangential spring is cut back
    to Coulomb's limit at every evaluation, as Cundall and Strack do.

    Raises
    ------
    ValueError
        The spheres do not approach each other.
    RuntimeError
        They have not parted after four times Hertz's duration.
    """
    a, b = touch.motions
    pair = PairLaw(law, *touch.spheres)
    position, velocity = b.centre - a.centre, b.velocity - a.velocity
    closing = -float(position @ velocity) / float(np.linalg.norm(position))
    if closing <= 0.0:
        raise ValueError(f"touching spheres must approach each other, found {closing} m/s")
    step = pair.duration(closing) / steps
    outer = touch.outer[1] - touch.outer[0]
    state = np.array([position, velocity, a.spin, b.spin, np.zeros(3)])
    history = [state]
    for _ in range(int(_LONGEST_CONTACT * steps)):
        middle = state + 0.5 * step * pair.rates(state, outer)
        state = state + step * pair.rates(middle, outer)
        history.append(state)
        if pair.overlap(state) <= 0.0:
            return _contact(touch, pair, np.array(history), step)
    raise RuntimeError(
        f"spheres at {closing} m/s have not parted after {_LONGEST_CONTACT} Hertz durations"
    )


def _contact(touch: Touch, pair: PairLaw, states: NDArray[np.float64], step: float) -> Contact:
    since = np.linspace(0.0, step * (len(states) - 1), len(states))
    overlaps = np.array([pair.overlap(state) for state in states])
    # The last step overshoots the separation; it is cut where the overlap vanishes.
    part = overlaps[-2] / (overlaps[-2] - overlaps[-1])
    states[-1] = states[-2] + part * (states[-1] - states[-2])
    since[-1] = since[-2] + part * step
    turns = _integrals(states[:, 2:4], since)
    kept = [*range(0, len(states) - 1, _KEEP_EVERY), len(states) - 1]
    motions = []
    for index in kept:
        a, b = touch.apart(states[index], float(since[index]))
        motions.append(
            (
                replace(a, orientation=turn(turns[index, 0], a.orientation)),
                replace(b, orientation=turn(turns[index, 1], b.orientation)),
            )
        )
    return Contact(
        times_s=touch.time_s + since[kept],
        motions=tuple(motions),
        normal=states[0, 0] / np.linalg.norm(states[0, 0]),
        normal_after=states[-1, 0] / np.linalg.norm(states[-1, 0]),
        compression_m=float(overlaps.max()),
    )


def _integrals(spins: NDArray[np.float64], since: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the running integral (N, 2, 3) of the spins, in rad, by the trapezoidal rule.

    A contact turns a sphere by some 0.01 rad, so that the order of the small turns is immaterial.
    """
    pieces = 0.5 * (spins[1:] + spins[:-1]) * np.diff(since)[:, None, None]
    return np.concatenate([np.zeros((1, 2, 3)), np.cumsum(pieces, axis=0)])
