"""How a plate lies that a sphere bounces on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.setup import SphereSetup

LEVEL_WITHIN_RAD = 0.01
"""What a spirit level leaves of a plate, and of the camera against it."""


@dataclass(frozen=True, slots=True)
class Plate:
    """A plane.

    Attributes
    ----------
    normal
        Unit vector from the sphere into it, rig axes; of a level plate along +X.
    sigma_rad
        Standard error of its direction about each of two axes.
    """

    normal: tuple[float, float, float] = (1.0, 0.0, 0.0)
    sigma_rad: float = LEVEL_WITHIN_RAD


LEVEL = Plate()


def stated_plate(body: SphereSetup) -> Plate:
    """Return the plate that campaign.toml states, or a level one where it states no normal."""
    if body.normal is None:
        return LEVEL
    x, y, z = np.array(body.normal) / np.linalg.norm(body.normal)
    return Plate((float(x), float(y), float(z)))
