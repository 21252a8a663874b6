"""Unit quaternions, scalar first, rotating body axes into rig axes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


def turn(rotation_vector: NDArray[np.float64], q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Turn the orientation `q` (4,) by a rotation vector (3,) in rad, given in rig axes."""
    angle = math.sqrt(float(rotation_vector @ rotation_vector))
    # sin(x/2)/x stays finite where the angle vanishes.
    vector = rotation_vector * (0.5 * float(np.sinc(angle / (2.0 * math.pi))))
    return product(np.array([math.cos(angle / 2.0), *vector]), q)


def product(p: NDArray[np.float64], q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return Hamilton's product p q: the rotation q followed by p, both (4,)."""
    a, b, c, d = p
    e, f, g, h = q
    return np.array(
        [
            a * e - b * f - c * g - d * h,
            a * f + b * e + c * h - d * g,
            a * g - b * h + c * e + d * f,
            a * h + b * g - c * f + d * e,
        ]
    )


def matrix(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rotation matrix (3, 3) of a unit quaternion: rig vector = matrix @ body vector."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def random_orientation(rng: np.random.Generator) -> NDArray[np.float64]:
    """Draw an orientation (4,) uniformly from all rotations."""
    q = rng.normal(size=4)
    return q / np.linalg.norm(q)
