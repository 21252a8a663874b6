"""When and where the spheres touch (thesis, section 5.3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def touching_time(separation: Floats, relative_velocity: Floats, distance: float) -> float | None:
    """Return the time until two spheres on straight paths first touch.

    Smaller root of |dW + dV t|^2 = D^2, equations (5-34) to (5-37) with c = sum(dW^2) - D^2; the
    thesis prints (5-36) without D^2. Before contact the spheres approach, so the smaller root is
    the touch; the larger is where they would part if they passed through each other.

    Parameters
    ----------
    separation
        Centre of b minus centre of a, m, shape (3,).
    relative_velocity
        Velocity of b minus velocity of a, m/s, shape (3,).
    distance
        Half the sum of the diameters, m.

    Returns
    -------
    Seconds, negative where they touched before; None where they pass each other by.
    """
    a = float(relative_velocity @ relative_velocity)
    b = float(separation @ relative_velocity)
    c = float(separation @ separation) - distance**2
    discriminant = b**2 - a * c
    if a == 0.0 or discriminant < 0.0:
        return None
    return (-b - float(np.sqrt(discriminant))) / a
