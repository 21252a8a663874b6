"""The contact of two spheres as forces integrated in time.

Normal: Hertz's elastic force with Tsuji's damping, F = k d^(3/2) + c d^(1/4) d', never pulling.
Tangential: Cundall and Strack's spring and dashpot under Coulomb's limit.

References
----------
Tsuji, Tanaka, Ishida, Powder Technology 71 (1992) 239-250, doi:10.1016/0032-5910(92)88030-L.
Cundall, Strack, Geotechnique 29 (1979) 47-65, doi:10.1680/geot.1979.29.1.47.
Schwager, Poeschel, Granular Matter 9 (2007) 465-469, doi:10.1007/s10035-007-0065-z.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from simulators.world.description import ContactLaw, Sphere
from simulators.world.rotation import turn
from simulators.world.state import Motion, Pose

Vector = NDArray[np.float64]

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
    def duration_s(self) -> float:
        """From first touch to separation."""
        return float(self.times_s[-1] - self.times_s[0])

    def pose(self, index: int, time_s: float) -> Pose:
        """Return the pose of a (0) or b (1) during the contact."""
        step = int(np.searchsorted(self.times_s, time_s, side="right")) - 1
        motion, since = self.motions[step][index], time_s - self.times_s[step]
        return Pose(
            motion.centre + motion.velocity * since,
            turn(motion.spin * since, motion.orientation),
        )


def damping_ratio(restitution: float) -> float:
    """Return the fraction of critical damping that gives this normal restitution.

    In the variable d^(5/4) the damped Hertz contact is a linear damped oscillator that ends when
    its force vanishes, so that e = exp(-z/s (pi - atan2(2 z s, 1 - 2 z^2))), s = sqrt(1 - z^2)
    (Schwager and Poeschel 2007), whatever the speed.

    Raises
    ------
    ValueError
        Restitution is not in (0.2, 1]; the law is not meant for softer impacts.
    """
    if not 0.2 < restitution <= 1.0:
        raise ValueError(f"restitution must lie in (0.2, 1], found {restitution}")
    if restitution == 1.0:
        return 0.0

    def excess(z: float) -> float:
        s = math.sqrt(1.0 - z * z)
        return math.exp(-z / s * (math.pi - math.atan2(2 * z * s, 1 - 2 * z * z))) - restitution

    return float(brentq(excess, 0.0, 0.95, xtol=1e-14))


class _Law:
    """Constants of one pair of spheres, and the rates of its state.

    The state (5, 3) is: position and velocity of b relative to a, spin of a, spin of b, and the
    elongation of the tangential spring in m.
    """

    def __init__(self, law: ContactLaw, a: Sphere, b: Sphere) -> None:
        radius = a.radius_m * b.radius_m / (a.radius_m + b.radius_m)
        modulus = law.youngs_modulus_pa / (2.0 * (1.0 - law.poissons_ratio**2))
        self.a, self.b, self.friction = a, b, law.friction
        self.reach = a.radius_m + b.radius_m
        self.mass = a.mass_kg * b.mass_kg / (a.mass_kg + b.mass_kg)
        self.stiffness = 4.0 / 3.0 * modulus * math.sqrt(radius)
        self.damping = damping_ratio(law.restitution) * math.sqrt(5.0 * self.mass * self.stiffness)
        mobility = 1.0 / self.mass
        mobility += a.radius_m**2 / a.inertia_kg_m2 + b.radius_m**2 / b.inertia_kg_m2
        self.tangential = law.tangential_stiffness_ratio * 1.5 * self.stiffness
        self.tangential_damping = (
            2.0 * law.tangential_damping_ratio * math.sqrt(self.tangential / mobility)
        )

    def duration(self, speed: float) -> float:
        """Return Hertz's duration of an undamped central contact, 2.94 x_max / v, in s."""
        largest = (5.0 * self.mass * speed**2 / (4.0 * self.stiffness)) ** 0.4
        return 2.94 * float(largest) / speed

    def overlap(self, state: NDArray[np.float64]) -> float:
        """Return by how much the spheres overlap, in m; negative is a gap."""
        return self.reach - math.sqrt(float(state[0] @ state[0]))

    def rates(self, state: NDArray[np.float64], outer: Vector) -> NDArray[np.float64]:
        """Return the time derivative of the state, and shorten its spring where it slips.

        `outer` (3,) is the difference of the outer accelerations, b less a.
        """
        position, velocity, spin_a, spin_b, _ = state
        distance = math.sqrt(float(position @ position))
        normal = position / distance
        overlap = max(self.reach - distance, 0.0)
        root = math.sqrt(overlap)
        speed = float(velocity @ normal)
        arm_a, arm_b = self.a.radius_m - overlap / 2.0, self.b.radius_m - overlap / 2.0
        slip = velocity - speed * normal - cross(arm_a * spin_a + arm_b * spin_b, normal)
        push = self.stiffness * overlap * root - self.damping * math.sqrt(root) * speed
        push = max(push, 0.0)
        drag = self._tangential_force(state, normal, slip, root, self.friction * push)
        torque = cross(drag, normal)
        return np.array(
            [
                velocity,
                (push * normal + drag) / self.mass + outer,
                arm_a / self.a.inertia_kg_m2 * torque,
                arm_b / self.b.inertia_kg_m2 * torque,
                slip,
            ]
        )

    def _tangential_force(
        self, state: NDArray[np.float64], normal: Vector, slip: Vector, root: float, limit: float
    ) -> Vector:
        if root == 0.0:
            return np.zeros(3)
        stiffness = self.tangential * root
        spring = state[4] - float(state[4] @ normal) * normal
        spring *= _shrink(spring, limit / stiffness)
        state[4] = spring
        force = -stiffness * spring - self.tangential_damping * math.sqrt(root) * slip
        return force * _shrink(force, limit)


def collide(
    a: Motion,
    b: Motion,
    spheres: tuple[Sphere, Sphere],
    start_s: float,
    law: ContactLaw,
    outer: tuple[Vector, Vector],
    steps: int = _STEPS_PER_CONTACT,
) -> Contact:
    """Integrate the contact of two touching spheres until they part.

    Midpoint rule with steps of 1/`steps` of Hertz's duration; the spring is cut back to
    Coulomb's limit at every evaluation, as Cundall and Strack do.

    Parameters
    ----------
    a, b
        Motions at first touch.
    outer
        Acceleration of each sphere by everything else, (3,) in m/s^2, constant over the contact.

    Raises
    ------
    ValueError
        The spheres do not approach each other.
    RuntimeError
        They have not parted after four times Hertz's duration.
    """
    pair = _Law(law, *spheres)
    position = b.centre - a.centre
    normal = position / np.linalg.norm(position)
    closing = -float((b.velocity - a.velocity) @ normal)
    if closing <= 0.0:
        raise ValueError(f"touching spheres must approach, found {closing} m/s")
    step = pair.duration(closing) / steps
    difference = outer[1] - outer[0]
    state = np.array([position, b.velocity - a.velocity, a.spin, b.spin, np.zeros(3)])
    history = [state]
    for _ in range(int(_LONGEST_CONTACT * steps)):
        middle = state + 0.5 * step * pair.rates(state, difference)
        state = state + step * pair.rates(middle, difference)
        history.append(state)
        if pair.overlap(state) <= 0.0:
            return _contact(a, b, spheres, start_s, step, history, outer, pair)
    raise RuntimeError(
        f"spheres at {closing} m/s have not parted after {_LONGEST_CONTACT} Hertz durations"
    )


def _contact(
    a: Motion,
    b: Motion,
    spheres: tuple[Sphere, Sphere],
    start_s: float,
    step: float,
    history: list[NDArray[np.float64]],
    outer: tuple[Vector, Vector],
    pair: _Law,
) -> Contact:
    states = np.array(history)
    since = step * np.arange(len(states))
    overlaps = pair.reach - np.linalg.norm(states[:, 0], axis=1)
    # The last step overshoots the separation; it is cut where the overlap vanishes.
    part = overlaps[-2] / (overlaps[-2] - overlaps[-1])
    states[-1] = states[-2] + part * (states[-1] - states[-2])
    since[-1] = since[-2] + part * step
    turns = _integrals(states[:, 2:4], since)
    kept = [*range(0, len(states) - 1, _KEEP_EVERY), len(states) - 1]
    motions = []
    for index in kept:
        motion_a, motion_b = _apart(a, b, spheres, states[index], since[index], outer)
        motions.append(
            (
                replace(motion_a, orientation=turn(turns[index, 0], a.orientation)),
                replace(motion_b, orientation=turn(turns[index, 1], b.orientation)),
            )
        )
    return Contact(
        times_s=start_s + since[kept],
        motions=tuple(motions),
        normal=states[0, 0] / np.linalg.norm(states[0, 0]),
        normal_after=states[-1, 0] / np.linalg.norm(states[-1, 0]),
        compression_m=float(overlaps.max()),
    )


def _apart(
    a: Motion,
    b: Motion,
    spheres: tuple[Sphere, Sphere],
    state: NDArray[np.float64],
    since: float,
    outer: tuple[Vector, Vector],
) -> tuple[Motion, Motion]:
    """Return both motions from the relative one: the centre of mass moves as if untouched."""
    share_a = spheres[0].mass_kg / (spheres[0].mass_kg + spheres[1].mass_kg)
    share_b = 1.0 - share_a
    pull = share_a * outer[0] + share_b * outer[1]
    velocity = share_a * a.velocity + share_b * b.velocity
    centre = share_a * a.centre + share_b * b.centre
    centre = centre + velocity * since + 0.5 * pull * since**2
    velocity = velocity + pull * since
    position, relative, spin_a, spin_b, _ = state
    return (
        Motion(centre - share_b * position, velocity - share_b * relative, a.orientation, spin_a),
        Motion(centre + share_a * position, velocity + share_a * relative, b.orientation, spin_b),
    )


def _integrals(spins: NDArray[np.float64], since: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the running integral (N, 2, 3) of the spins, in rad, by the trapezoidal rule.

    A contact turns a sphere by some 0.01 rad, so that the order of the small turns is immaterial.
    """
    pieces = 0.5 * (spins[1:] + spins[:-1]) * np.diff(since)[:, None, None]
    return np.concatenate([np.zeros((1, 2, 3)), np.cumsum(pieces, axis=0)])


def cross(p: Vector, q: Vector) -> Vector:
    """Return p x q for two (3,) vectors, far faster than the general routine."""
    a, b, c = p.tolist()
    d, e, f = q.tolist()
    return np.array([b * f - c * e, c * d - a * f, a * e - b * d])


def _shrink(vector: Vector, longest: float) -> float:
    """Return the factor that brings a vector to at most the given length."""
    length = math.sqrt(float(vector @ vector))
    return 1.0 if length <= longest else longest / length
