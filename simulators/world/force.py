"""The force between two touching spheres.

Normal: Hertz's elastic force with Tsuji's damping, F = k d^(3/2) + c d^(1/4) d', never pulling.
Tangential: Cundall and Strack's spring and dashpot under Coulomb's limit; the spring's stiffness
is a fixed part of the Hertz force's tangent, so that only ratios of speeds matter.

References
----------
Tsuji, Tanaka, Ishida, Powder Technology 71 (1992) 239-250, doi:10.1016/0032-5910(92)88030-L.
Cundall, Strack, Geotechnique 29 (1979) 47-65, doi:10.1680/geot.1979.29.1.47.
Schwager, Poeschel, Granular Matter 9 (2007) 465-469, doi:10.1007/s10035-007-0065-z.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from simulators.world.description import ContactLaw, Sphere
from simulators.world.vectors import Triple, added, crossed, dot, times, triple

Vector = NDArray[np.float64]
"""Three components in rig axes."""


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
    # Loaded with the first flight.
    from scipy.optimize import brentq  # noqa: PLC0415

    def excess(z: float) -> float:
        s = math.sqrt(1.0 - z * z)
        return math.exp(-z / s * (math.pi - math.atan2(2 * z * s, 1 - 2 * z * z))) - restitution

    return float(brentq(excess, 0.0, 0.95, xtol=1e-14))


class PairLaw:
    """Constants of one pair of spheres, and the rates of its state in contact.

    The state (5, 3) is: position and velocity of b relative to a, spin of a, spin of b, and the
    elongation of the tangential spring in m.
    """

    def __init__(self, law: ContactLaw, a: Sphere, b: Sphere) -> None:
        radius = a.radius_m * b.radius_m / (a.radius_m + b.radius_m)
        modulus = law.youngs_modulus_pa / (2.0 * (1.0 - law.poissons_ratio**2))
        self.a, self.b, self.friction = a, b, law.friction
        self.reach = a.radius_m + b.radius_m
        self.mass = a.mass_kg * b.mass_kg / (a.mass_kg + b.mass_kg)
        self.inertias = a.inertia_kg_m2, b.inertia_kg_m2
        self.stiffness = 4.0 / 3.0 * modulus * math.sqrt(radius)
        self.damping = damping_ratio(law.restitution) * math.sqrt(5.0 * self.mass * self.stiffness)
        mobility = 1.0 / self.mass
        mobility += a.radius_m**2 / self.inertias[0] + b.radius_m**2 / self.inertias[1]
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
        position, velocity, spin_a, spin_b, spring = map(triple, state)
        distance = math.sqrt(dot(position, position))
        normal = (position[0] / distance, position[1] / distance, position[2] / distance)
        overlap = max(self.reach - distance, 0.0)
        root = math.sqrt(overlap)
        speed = dot(velocity, normal)
        arm_a, arm_b = self.a.radius_m - overlap / 2.0, self.b.radius_m - overlap / 2.0
        whirl = crossed(added(times(arm_a, spin_a), arm_b, spin_b), normal)
        slip = added(added(velocity, -speed, normal), -1.0, whirl)
        push = self.stiffness * overlap * root - self.damping * math.sqrt(root) * speed
        push = max(push, 0.0)
        drag = (0.0, 0.0, 0.0)
        if root != 0.0:
            limit, stiffness = self.friction * push, self.tangential * root
            spring = _cut(added(spring, -dot(spring, normal), normal), limit / stiffness)
            state[4] = spring
            damping = self.tangential_damping * math.sqrt(root)
            drag = _cut(added(times(-stiffness, spring), -damping, slip), limit)
        torque = crossed(drag, normal)
        force = added(drag, push, normal)
        return np.array(
            [
                velocity,
                added(triple(outer), 1.0 / self.mass, force),
                times(arm_a / self.inertias[0], torque),
                times(arm_b / self.inertias[1], torque),
                slip,
            ]
        )


def _cut(vector: Triple, longest: float) -> Triple:
    """Return a vector of at most the given length."""
    length = math.sqrt(dot(vector, vector))
    return vector if length <= longest else times(longest / length, vector)
