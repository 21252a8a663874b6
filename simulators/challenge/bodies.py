"""The two spheres as they really are, whatever they were said to be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulators.challenge.nature import Nature
from simulators.world.description import Sphere

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Bodies:
    """Masses, kg, and moments of inertia, kg m^2, of a and b (2,), and their common radius, m."""

    mass: Floats
    inertia: Floats
    radius_m: float

    @classmethod
    def of(cls, sphere: Sphere, nature: Nature) -> Bodies:
        """Return what the spheres really are, by whatever they were said to be."""
        difference = nature.mass_difference * np.array([1.0, -1.0])
        mass = sphere.mass_kg * (1.0 + difference)
        factor = sphere.inertia_factor * (1.0 + nature.inertia_excess)
        return cls(mass, factor * mass * sphere.radius_m**2, sphere.radius_m)

    @property
    def normal_mobility(self) -> float:
        """Change of the approach speed by a unit impulse, 1/kg."""
        return float((1.0 / self.mass).sum())

    @property
    def surface_mobility(self) -> float:
        """Change of the slip by a unit tangential impulse, 1/kg."""
        return self.normal_mobility + float((self.radius_m**2 / self.inertia).sum())
