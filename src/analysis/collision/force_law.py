"""Force laws of a contact that lasts: which power of the overlap presses, which one damps.

Along the normal N = k x^p - c x^q dx/dt, never pulling, x the overlap. Across it a spring of
stiffness kappa dN/dx and a dashpot under Coulomb's limit mu N. Simulation codes differ in what the
spring keeps while its stiffness changes, and in where the dashpot acts.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import gamma
from typing import Literal

import numpy as np

from analysis.arrays import Floats
from analysis.collision.operator import Body, inverse_masses

History = Literal["elongation", "increment"]
REFERENCE_SPEED = 2.0
"""m/s: the approach speed at which e of a law whose e depends on speed is the stated one."""


@dataclass(frozen=True, slots=True)
class NormalForce:
    """N = k x^p - c x^q dx/dt.

    Attributes
    ----------
    title
        As its field calls it.
    elastic, damping
        The exponents p and q.
    as_asked
        Whether c is taken anew for each contact, so that restitution is as it is asked for and
        depends on speed only where an effect has it do so.
    """

    title: str
    elastic: float
    damping: float
    as_asked: bool = False

    @property
    def depth_exponent(self) -> float:
        """Return the power of the speed with which the depth grows: v^(2 / (p + 1))."""
        return 2.0 / (self.elastic + 1.0)

    @property
    def loss_exponent(self) -> float:
        """Return the power of the speed with which the dimensionless damping grows.

        0 where restitution does not depend on speed.
        """
        if self.as_asked:
            return 0.0
        return 1.0 + (self.damping - self.elastic) * self.depth_exponent

    @property
    def elastic_duration(self) -> float:
        """Return the duration of an undamped contact in units of L / v, L = (m* v^2 / k)^(1/(p+1)).

        2 (x_max / L) int_0^1 dy / sqrt(1 - y^(p+1)): 3.218 of Hertz's force, pi of a linear spring.
        """
        n = self.elastic + 1.0
        deepest = (n / 2.0) ** (1.0 / n)
        return float(2 * deepest * gamma(0.5) * gamma(1 + 1 / n) / gamma(0.5 + 1 / n))

    def stiffness(self, mass: float, duration_s: float | Floats) -> Floats:
        """Return k, N/m^p, of a reduced mass (kg) that an undamped contact turns in so many s.

        At an approach speed of 1 m/s; of one duration or of many.
        """
        length = np.asarray(duration_s) / self.elastic_duration
        return np.asarray(mass / length ** (self.elastic + 1.0))


TSUJI = NormalForce("Hertz's force with Tsuji's damping", 1.5, 0.25)
"""Y. Tsuji, T. Tanaka and T. Ishida, Powder Technol. 71, 239 (1992): e does not depend on speed."""
KUWABARA_KONO = NormalForce("Hertz's force with viscous damping", 1.5, 0.5)
"""G. Kuwabara and K. Kono, Jpn. J. Appl. Phys. 26, 1230 (1987): e falls with speed."""
VISCOUS = NormalForce("Hertz's force with Kuwabara and Kono's damping", 1.5, 0.5, as_asked=True)
"""The same course of the force; how e falls with speed is left to an effect of that name."""
CONSTANT_DASHPOT = NormalForce("Hertz's force with a constant dashpot", 1.5, 0.0)
"""J. Lee and H. J. Herrmann, J. Phys. A 26, 373 (1993): e rises with speed."""
LINEAR = NormalForce("linear spring and dashpot", 1.0, 0.0)
"""P. A. Cundall and O. D. L. Strack, Geotechnique 29, 47 (1979): all contacts last as long."""


@dataclass(frozen=True, slots=True)
class ForceLaw:
    """Normal and tangential force of a contact.

    Attributes
    ----------
    normal
        Along the line of centres.
    history
        What the tangential spring keeps while its stiffness changes: its "elongation", so that the
        force follows the stiffness, or its force, to which each "increment" of slip adds.
    dashpot_slides
        Whether the tangential dashpot acts also while the contact slides.
    shortened
        Whether the levers end at the middle of the overlap, or at the spheres' own radii.
    """

    normal: NormalForce
    history: History
    dashpot_slides: bool = True
    shortened: bool = True

    @property
    def title(self) -> str:
        """Return its name among the force laws."""
        parts = [self.normal.title, f"tangential spring by {self.history}"]
        if not self.dashpot_slides:
            parts.append("damped while it sticks")
        if not self.shortened:
            parts.append("levers of full length")
        return ", ".join(parts)


def hertz_duration(modulus: float, bodies: tuple[Body, Body]) -> float:
    """Return how long an undamped Hertzian contact of a contact modulus E*, Pa, lasts at 1 m/s, s.

    F = (4/3) E* sqrt(R*) x^(3/2): K. L. Johnson, Contact Mechanics (1985), section 11.4. At another
    approach speed v, m/s, it is v^(-1/5) times that.
    """
    a, b = bodies
    curvature = 1 / a.radius + (0.0 if b.is_plate else 1 / b.radius)
    stiffness = 4 / 3 * modulus * curvature**-0.5
    mass = 1 / inverse_masses(bodies)[0]
    return float(TSUJI.elastic_duration * (mass / stiffness) ** 0.4)


def stated_modulus(bodies: tuple[Body, Body]) -> float | None:
    """Return the contact modulus E*, Pa, of bodies whose materials are stated; else None.

    1 / E* = (1 - nu_a^2) / E_a + (1 - nu_b^2) / E_b.
    """
    a, b = (body.material for body in bodies)
    if a is None or b is None:
        return None
    return 1.0 / (1.0 / a.plane_modulus + 1.0 / b.plane_modulus)


def yield_speed(bodies: tuple[Body, Body]) -> float | None:
    """Return the approach speed, m/s, above which the softer material yields; None: not stated.

    m* v_y^2 / 2 = 53 R*^3 Y^5 / E*^4: K. L. Johnson, Contact Mechanics (1985), section 11.5.
    """
    modulus = stated_modulus(bodies)
    stresses = [body.material.yield_pa for body in bodies if body.material is not None]
    told = [stress for stress in stresses if stress is not None]
    if modulus is None or not told:
        return None
    a, b = bodies
    radius = 1.0 / (1 / a.radius + (0.0 if b.is_plate else 1 / b.radius))
    mass = 1 / inverse_masses(bodies)[0]
    return float(np.sqrt(106.0 * radius**3 * min(told) ** 5 / (mass * modulus**4)))
