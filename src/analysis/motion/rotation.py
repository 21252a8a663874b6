"""Rotation of a sphere from the directions of its markers (thesis, section 5.2)."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats

TINY_RAD = 1e-150
"""Angle in place of zero, so that sin(angle) / angle is 1 and not 0 / 0."""


def rotation_vector(rotation: Floats) -> Floats:
    """Return axis times angle (radians, 0 to pi) of rotations, shape (..., 3, 3) to (..., 3).

    Equations (5-15) to (5-22): below 90 degrees from the differences of the off-diagonal elements,
    above from the largest diagonal element and the sums.
    """
    skew = rotation[..., (2, 0, 1), (1, 2, 0)] - rotation[..., (1, 2, 0), (2, 0, 1)]
    twice_sin = np.sqrt((skew * skew).sum(axis=-1))
    twice_cos = rotation[..., 0, 0] + rotation[..., 1, 1] + rotation[..., 2, 2] - 1.0
    angle = np.arctan2(twice_sin, twice_cos)
    small = twice_sin < 1e-9
    vector = skew * np.where(small, 0.5, angle / np.where(small, 1.0, twice_sin))[..., None]
    # Towards half a turn the differences vanish with the sine; the sums give the axis.
    beyond = twice_cos < 0.0
    if beyond.any():
        axis = _axis_by_sums(rotation[beyond], skew[beyond])
        vector[beyond] = angle[beyond][:, None] * axis
    return np.asarray(vector)


def _axis_by_sums(rotation: Floats, skew: Floats) -> Floats:
    """Return the axes of turns beyond 90 degrees, shapes (N, 3, 3) and (N, 3) to (N, 3).

    From row and column of the largest diagonal element; the differences give the sense.
    """
    rows = np.arange(len(rotation))
    largest = np.diagonal(rotation, axis1=1, axis2=2).argmax(axis=1)
    axis = rotation[rows, largest] + rotation[rows, :, largest]
    # 2 (1 - cos) n_k n, with the diagonal less its cosine.
    trace = np.trace(rotation, axis1=1, axis2=2)
    axis[rows, largest] += 1.0 - trace
    axis *= np.where(skew[rows, largest] < 0, -1.0, 1.0)[:, None]
    return np.asarray(axis / np.linalg.norm(axis, axis=1, keepdims=True))


def rotation_matrix(vector: Floats) -> Floats:
    """Return the rotation by |vector| radians about vector, shape (..., 3) to (..., 3, 3)."""
    vector = np.asarray(vector, dtype=np.float64)
    square = np.asarray((vector * vector).sum(axis=-1))
    angle = np.maximum(np.sqrt(square), TINY_RAD)
    sine, versine = np.sin(angle) / angle, 0.5 * (np.sin(angle / 2) / (angle / 2)) ** 2
    matrix = versine[..., None, None] * (vector[..., :, None] * vector[..., None, :])
    cosine, turned = 1.0 - versine * square, sine[..., None] * vector
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        matrix[..., k, k] += cosine
        matrix[..., j, i] += turned[..., k]
        matrix[..., i, j] -= turned[..., k]
    return np.asarray(matrix)


def quaternion(rotation: Floats) -> Floats:
    """Return unit quaternions, scalar first and not negative, shape (..., 3, 3) to (..., 4)."""
    vector = rotation_vector(rotation)
    angle = np.linalg.norm(vector, axis=-1, keepdims=True)
    half = 0.5 * np.sinc(angle / (2 * np.pi))
    return np.concatenate([np.cos(angle / 2), half * vector], axis=-1)
