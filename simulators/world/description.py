"""What the simulated world is made of: numbers only, with units, no behaviour beyond formulas."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from simulators.world.optics import Optics


@dataclass(frozen=True, slots=True)
class Sphere:
    """A homogeneous marked sphere.

    Parameters
    ----------
    diameter_m, density_kg_per_m3
        Size and material; a one-inch nylon sphere by default.
    inertia_factor
        I / (m r^2); 2/5 for a solid sphere.
    markers
        Number of round dark markers on the surface.
    marker_radius_rad
        Angular radius of a marker, seen from the centre of the sphere; below pi / 2.
    marker_reflectance
        Brightness of a marker relative to the surface about it.
    """

    diameter_m: float = 0.0254
    density_kg_per_m3: float = 1150.0
    inertia_factor: float = 0.4
    markers: int = 16
    marker_radius_rad: float = 0.16
    marker_reflectance: float = 0.3

    @property
    def radius_m(self) -> float:
        """Radius in m."""
        return self.diameter_m / 2.0

    @property
    def mass_kg(self) -> float:
        """Mass in kg."""
        return self.density_kg_per_m3 * math.pi / 6.0 * self.diameter_m**3

    @property
    def inertia_kg_m2(self) -> float:
        """Moment of inertia about any diameter, in kg m^2."""
        return self.inertia_factor * self.mass_kg * self.radius_m**2


@dataclass(frozen=True, slots=True)
class Tube:
    """A launching tube with a pneumatic pusher, and its shot-to-shot scatter.

    The sphere rests just inside the mouth, out of the camera's sight. After `valve_delay_s` the
    pusher drives it with constant force over `stroke_m`; it then coasts, guided, until its centre
    passes the mouth. The defaults give 1.30 m/s at 25 kPa and 2.79 m/s at 95 kPa.

    Parameters
    ----------
    mouth_m
        Distance of the mouth from the middle of the field, along Y.
    height_m
        X of the tube's axis at zero offset; negative is above the origin, so that the mean of
        the gravity drops brings the spheres together near it.
    piston_area_m2, stroke_m
        The pusher's effective area and stroke.
    friction_n
        Constant resistance of pusher and sphere. Below `friction_n / piston_area_m2` the sphere
        stays in the tube.
    valve_delay_s, valve_jitter_s
        From the electrical pulse to full pressure: mean and standard deviation.
    speed_scatter
        Standard deviation of the speed, relative.
    direction_scatter_rad
        Standard deviation of the direction, about X and about Z each.
    position_scatter_m
        Standard deviation of the exit point, in X and in Z each.
    spin_scatter_rad_per_s
        Standard deviation of each component of the spin the tube gives.
    """

    mouth_m: float = 0.078
    height_m: float = -0.007
    piston_area_m2: float = 7.22e-5
    stroke_m: float = 0.006
    friction_n: float = 0.416
    valve_delay_s: float = 0.001
    valve_jitter_s: float = 5.0e-5
    speed_scatter: float = 0.008
    direction_scatter_rad: float = 0.004
    position_scatter_m: float = 1.0e-4
    spin_scatter_rad_per_s: float = 20.0


@dataclass(frozen=True, slots=True)
class TiltedTubes:
    """Two tubes turned by hand, a solenoid in each (first apparatus of the thesis, section 3.2).

    A solenoid holds its sphere `length_m` up the tube; let go, the sphere rolls down without
    slipping and leaves at sqrt(2 g L sin(angle) / (1 + I / (m r^2))) along the tube.

    Parameters
    ----------
    mouth_m, height_m
        Where a sphere's centre leaves: distance from the middle of the field along Y, and X.
    length_m
        Way that a sphere rolls.
    angle_a_deg, angle_b_deg
        Tilt of each tube below the horizontal, as somebody has turned it.
    release_delay_s, release_jitter_s
        From the switched contact to the loose sphere: mean and standard deviation.
    speed_scatter, direction_scatter_rad, position_scatter_m, spin_scatter_rad_per_s
        As of `Tube`.
    """

    mouth_m: float = 0.078
    height_m: float = -0.058
    length_m: float = 0.2
    angle_a_deg: float = 30.0
    angle_b_deg: float = 30.0
    release_delay_s: float = 0.006
    release_jitter_s: float = 2.0e-4
    speed_scatter: float = 0.004
    direction_scatter_rad: float = 0.003
    position_scatter_m: float = 1.0e-4
    spin_scatter_rad_per_s: float = 2.0


@dataclass(frozen=True, slots=True)
class Magnet:
    """A magnet that holds sphere a and lets it fall, on a plate or past the field (chapter 6).

    Parameters
    ----------
    height_m
        X of the held sphere's centre; negative is above the origin.
    plate_m
        X of the plate's surface.
    release_delay_s, release_jitter_s
        As of `TiltedTubes`.
    position_scatter_m, drift_scatter_m_per_s, spin_scatter_rad_per_s
        Standard deviations along Y and along Z, of the sideways speed, and of each component of
        the spin, that a sticking magnet gives.
    """

    height_m: float = -0.06
    plate_m: float = 0.5
    release_delay_s: float = 0.004
    release_jitter_s: float = 1.0e-3
    position_scatter_m: float = 3.0e-4
    drift_scatter_m_per_s: float = 3.0e-3
    spin_scatter_rad_per_s: float = 0.2


@dataclass(frozen=True, slots=True)
class ContactLaw:
    """Damped Hertz contact with a tangential spring, a dashpot and Coulomb's limit.

    Parameters
    ----------
    youngs_modulus_pa, poissons_ratio
        Of both spheres; 3 GPa lets a contact at 1.3 to 5.6 m/s last 0.18 to 0.13 ms.
    restitution
        Normal restitution of a central impact; the damping follows from it
        (`force.damping_ratio`) and does not depend on speed.
    friction
        Coulomb coefficient.
    tangential_stiffness_ratio
        Tangential stiffness over the tangent of the Hertz force. Mindlin's value for an elastic
        solid is 2 (1 - nu) / (2 - nu), about 0.75; the default is chosen so that rolling impacts
        reverse the surface velocity as thesis section 7.1 found for nylon (beta0 about 0.7).
    tangential_damping_ratio
        Dashpot beside the tangential spring, as a fraction of critical damping.
    """

    youngs_modulus_pa: float = 3.0e9
    poissons_ratio: float = 0.4
    restitution: float = 0.74
    friction: float = 0.08
    tangential_stiffness_ratio: float = 0.15
    tangential_damping_ratio: float = 0.05


@dataclass(frozen=True, slots=True)
class Environment:
    """Gravity along +X, and still air.

    The drag coefficient is that of a smooth sphere at Reynolds numbers of 2000 to 5000.
    """

    gravity_m_per_s2: float = 9.80665
    air_density_kg_per_m3: float = 1.2
    drag_coefficient: float = 0.4


@dataclass(frozen=True, slots=True)
class WorldDescription:
    """Everything the simulated world obeys; the defaults are the thesis's nylon rig.

    `holder` is what lets spheres go where no pusher fires them; None: the tubes have pushers.
    """

    sphere_a: Sphere = field(default_factory=Sphere)
    sphere_b: Sphere = field(default_factory=Sphere)
    tube: Tube = field(default_factory=Tube)
    holder: TiltedTubes | Magnet | None = None
    contact: ContactLaw = field(default_factory=ContactLaw)
    environment: Environment = field(default_factory=Environment)
    optics: Optics = field(default_factory=Optics)
