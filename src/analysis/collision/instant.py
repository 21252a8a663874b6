"""When and where the spheres touch (thesis, section 5.3)."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats


class NoTouchError(Exception):
    """The paths before contact do not come as near as the spheres' radii together.

    Attributes
    ----------
    closest_m
        Least distance between the centres on those paths.
    """

    def __init__(self, closest_m: float) -> None:
        self.closest_m = closest_m
        super().__init__(f"closest approach of the centres {1e3 * closest_m:.2f} mm")


def touching_time(separation: Floats, relative_velocity: Floats, distance: Floats) -> Floats:
    """Return the time until two spheres on straight paths first touch, for one pair or many.

    Smaller root of |dW + dV t|^2 = D^2, equations (5-34) to (5-37) with c = sum(dW^2) - D^2; the
    thesis prints (5-36) without D^2. Before contact the spheres approach, so the smaller root is
    the touch; the larger is where they would part if they passed through each other.

    Parameters
    ----------
    separation
        Centre of b minus centre of a, m, shape (..., 3).
    relative_velocity
        Velocity of b minus velocity of a, m/s, shape (..., 3).
    distance
        Half the sum of the diameters, m, shape (...).

    Returns
    -------
    Seconds, negative where they touched before; NaN where they pass each other by, shape (...).
    """
    a = (relative_velocity**2).sum(axis=-1)
    b = (separation * relative_velocity).sum(axis=-1)
    c = (separation**2).sum(axis=-1) - distance**2
    discriminant = b**2 - a * c
    touch = (a > 0.0) & (discriminant >= 0.0)
    root = np.sqrt(np.where(touch, discriminant, np.nan))
    return np.asarray((-b - root) / np.where(touch, a, np.nan))


def parting_time(separation: Floats, relative_velocity: Floats, distance: Floats) -> Floats:
    """Return the time until two spheres on straight paths last touch: (5-34) run backwards.

    On the paths after contact this is where the spheres part, which a contact of finite length puts
    later than the touch on the paths before.

    Parameters and result are those of `touching_time`.
    """
    return -touching_time(separation, -relative_velocity, distance)
