"""The physics of a campaign as numbers, every departure from the plain theory a switch."""

from __future__ import annotations

from dataclasses import dataclass

from simulators.challenge.force_choice import Forces
from simulators.challenge.unnamed import Dependence

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Nature:
    """What the spheres, the air, the clock and the camera obey; the defaults are the plain theory.

    Speeds of reference are 2 m/s; "over the campaign" is from the first shot to the last, with
    the stated value in its middle. Vectors are in rig axes.

    Parameters
    ----------
    restitution, friction, rolling_restitution
        e, mu and beta0 of the hard-sphere law.
    viscosity
        Share of a fully viscoelastic contact of the same e at 2 m/s; the rest of the loss does
        not depend on speed.
    restitution_power
        e ~ v_n^-power.
    restitution_obliquity
        Relative change of e for each unit of v_s / v_n, up to 3.
    restitution_drift, friction_drift
        Relative change over the campaign.
    restitution_per_kelvin
        Relative change of e with the temperature of the room, from 23 degrees C.
    friction_speed
        Relative change of mu for each factor of e in the slip speed.
    inertia_excess
        Relative excess of both moments of inertia over those stated.
    mass_difference
        (m_a - m_b) / (m_a + m_b).
    torsion_radius_m
        Radius, at 2 m/s, of the contact spot that resists spinning about the normal.
    softness
        Duration of contact in units of Hertz's for solid nylon (3 GPa, 0.4); 0 is instantaneous.
    forces
        Of a contact that is followed in time by all of them; None: one of the plain theory.
    compliance
        Share of the tangential impulse that comes through elastic springs under the normal load.
    drag_coefficient, lift
        Quadratic drag; lift in units of the one that spin gives a smooth sphere.
    wind_m_per_s
        Velocity of the air; acts through the drag.
    gravity_tilt_rad
        The vertical's tilt toward +Y and toward +Z.
    dependence
        A coefficient that follows something by a law that no catalogue holds.
    pull_m_per_s2
        Acceleration of each sphere toward the other at touch; it fades over 8 mm of gap.
    central_m_per_s2, central_power
        The same, falling off as this power of the centres' distance.
    image_scale, frame_rate
        Relative excess of lengths in the image, and of the true frame interval over the stated.
    pixel_aspect
        Relative excess of the image's rows over its columns.
    mirror_rad
        Turn of the mirror about Y.
    roll_rad
        Turn of the picture about its middle.
    distortion
        Radial, relative, at the corner of the picture.
    shake_px, shake_hz
        Amplitude along the rows and frequency of a vibration of the camera, in step with the
        first frame.
    """

    restitution: float = 0.74
    friction: float = 0.08
    rolling_restitution: float = 0.5
    viscosity: float = 0.0
    restitution_power: float = 0.0
    restitution_obliquity: float = 0.0
    restitution_drift: float = 0.0
    restitution_per_kelvin: float = 0.0
    friction_drift: float = 0.0
    friction_speed: float = 0.0
    inertia_excess: float = 0.0
    mass_difference: float = 0.0
    torsion_radius_m: float = 0.0
    softness: float = 0.0
    forces: Forces | None = None
    compliance: float = 0.0
    drag_coefficient: float = 0.0
    lift: float = 0.0
    wind_m_per_s: Vector = (0.0, 0.0, 0.0)
    gravity_tilt_rad: tuple[float, float] = (0.0, 0.0)
    dependence: Dependence | None = None
    pull_m_per_s2: float = 0.0
    central_m_per_s2: float = 0.0
    central_power: float = 4.0
    image_scale: float = 0.0
    frame_rate: float = 0.0
    pixel_aspect: float = 0.0
    mirror_rad: float = 0.0
    roll_rad: float = 0.0
    distortion: float = 0.0
    shake_px: float = 0.0
    shake_hz: float = 120.0
