"""What is known of a shot beside its poses: bodies, surroundings, exposure, how poses err."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from analysis.collision.operator import Body
from analysis.motion.velocity import Drag
from analysis.setup import Setup, SlowErrors, SphereSetup

UNSTATED_DRAG = 0.4
"""Coefficient of a smooth sphere at Reynolds numbers of 1e3 to 1e5 (L. Schiller and A. Naumann,
1935): where none is stated it is an error at its full size, and nothing is taken out."""


@dataclass(frozen=True, slots=True)
class Scene:
    """Bodies and surroundings of a shot.

    Attributes
    ----------
    bodies
        Spheres a and b.
    gravity
        m/s^2 along +X.
    air_density
        kg/m^3.
    drag_coefficient, drag_sigma
        Of the spheres in air; None: not stated.
    exposure_s
        Time that the shutter was open about each frame's time; 0: poses of instants.
    slow
        Errors of the poses that last, and that of the scale.
    """

    bodies: tuple[Body, Body]
    gravity: float
    air_density: float
    drag_coefficient: float | None
    drag_sigma: float
    exposure_s: float
    slow: SlowErrors

    @classmethod
    def of(cls, setup: Setup, slow: SlowErrors, step_s: float | None = None) -> Scene:
        """Return the scene of frames that were measured with these slow errors.

        Where no exposure is stated the shutter may be open for all of `step_s`, the time between
        two frames; None: as the stated rate has it.
        """
        air, camera = setup.environment, setup.camera
        longest_s = 1.0 / camera.frame_rate_hz if step_s is None else step_s
        return cls(
            bodies=bodies_of(setup),
            gravity=air.gravity_m_per_s2,
            air_density=air.air_density_kg_per_m3,
            drag_coefficient=air.drag_coefficient,
            drag_sigma=air.drag_coefficient_sigma,
            exposure_s=longest_s if camera.exposure_s is None else camera.exposure_s,
            slow=slow,
        )

    @property
    def radii(self) -> tuple[float, float]:
        """Of a and b, m."""
        return self.bodies[0].radius, self.bodies[1].radius

    def drag(self, sphere: int) -> Drag:
        """Return the drag of a sphere: F = rho/2 Cd A v^2 over its mass."""
        body = self.bodies[sphere]
        of_one = self.air_density / 2 * np.pi * body.radius**2 / body.mass
        if self.drag_coefficient is None:
            return Drag(0.0, UNSTATED_DRAG * of_one)
        return Drag(self.drag_coefficient * of_one, self.drag_sigma * of_one)


def bodies_of(setup: Setup) -> tuple[Body, Body]:
    """Return both bodies that a set-up describes, of its material."""
    a, b = (replace(_body_of(sphere), material=setup.material) for sphere in setup.spheres)
    return a, b


def _body_of(sphere: SphereSetup) -> Body:
    if sphere.plate:
        return Body.plate()
    return Body.sphere(sphere.diameter_m, sphere.density_kg_per_m3, sphere.inertia_factor)
