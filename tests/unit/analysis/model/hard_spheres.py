"""Campaigns of hard spheres with known law and noise, made without any of the code under test.

The collision is worked out in scalars about the normal (Walton's two lines), orientations with
SciPy's rotations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from analysis.collision.operator import Body
from analysis.model.data.poses import PoseData
from analysis.setup import CameraSetup

Floats = NDArray[np.float64]

RADIUS, FRAMES, REACH = 0.0127, 24, 0.005
POSITION_SIGMA, ROTATION_SIGMA = 2e-5, 8e-3
GRAVITY = np.array([9.80665, 0.0, 0.0])
CAMERA = CameraSetup(1000.0, 192, 240, (88, 192), (0, 88), 1574.8, (132.0, 120.0), (46.0, 120.0))


@dataclass(frozen=True, slots=True)
class Hidden:
    """Physics that the base model lacks.

    slope
        Loss of e for each unit of (v_n^0.2 - 2^0.2) / 0.2.
    drag
        Deceleration for each unit of v^2, 1/m.
    pull
        Relative acceleration towards each other within 5 mm of touching, m/s^2.
    """

    slope: float = 0.0
    drag: float = 0.0
    pull: float = 0.0


NOTHING = Hidden()


@dataclass(frozen=True, slots=True)
class Drawn:
    """Normal (S, 3), velocities and spins before contact (S, 2, 3), instant of contact (S,), s."""

    normal: Floats
    velocity: Floats
    spin: Floats
    contact_s: Floats


def draw(
    rng: np.random.Generator, shots: int, interval_s: float = 1e-3, spread: float = 0.9
) -> Drawn:
    """Return what `shots` collisions happen to be, offsets up to `spread` diameters."""
    normal = np.stack(
        [rng.uniform(0, spread, shots), np.zeros(shots), rng.normal(0, 0.02, shots)], axis=1
    )
    normal[:, 1] = np.sqrt(1 - (normal**2).sum(axis=1))
    speed = rng.uniform(1.2, 2.8, shots)
    velocity = rng.normal(0, 0.02, (shots, 2, 3))
    velocity[:, 0, 1] += speed
    velocity[:, 1, 1] -= speed
    spin = rng.normal(0, 40, (shots, 2, 3))
    contact = (FRAMES / 2 - 0.5 + rng.uniform(-0.4, 0.4, shots)) * interval_s
    return Drawn(normal, velocity, spin, contact)


def campaign(
    shots: int,
    seed: int,
    law: tuple[float, float, float] = (0.74, 0.08, 0.5),
    *,
    hidden: Hidden = NOTHING,
    interval_s: float = 1e-3,
    position_sigma: float = POSITION_SIGMA,
    rotation_sigma: float = ROTATION_SIGMA,
) -> PoseData:
    """Return poses of `shots` collisions under (e, mu, beta0) with Gaussian noise as stated."""
    rng = np.random.default_rng(seed)
    drawn = draw(rng, shots, interval_s)
    after_velocity, after_spin = collided(
        drawn.velocity, drawn.spin, drawn.normal, law, hidden.slope
    )
    times = np.tile(np.arange(FRAMES) * interval_s, (shots, 1))
    tau = (times - drawn.contact_s[:, None])[..., None]
    start = Rotation.random(2 * shots, random_state=seed).as_matrix().reshape(shots, 2, 3, 3)
    position = np.zeros((shots, FRAMES, 2, 3))
    rotation = np.zeros((shots, FRAMES, 2, 3, 3))
    for i, side in enumerate((-RADIUS, RADIUS)):
        v = np.where(tau > 0, after_velocity[:, None, i], drawn.velocity[:, None, i])
        w = np.where(tau > 0, after_spin[:, None, i], drawn.spin[:, None, i])
        slowing = hidden.drag * np.linalg.norm(v, axis=-1, keepdims=True) * v
        position[:, :, i] = side * drawn.normal[:, None] + v * tau
        position[:, :, i] += (GRAVITY - slowing) * tau**2 / 2
        turned = Rotation.from_rotvec((w * tau).reshape(-1, 3)).as_matrix()
        rotation[:, :, i] = turned.reshape(shots, FRAMES, 3, 3) @ start[:, None, i]
    drawn_in = hidden.pull * _time_in_reach(position, tau) * drawn.normal[:, None] / 2
    position[:, :, 0] += drawn_in
    position[:, :, 1] -= drawn_in
    position += rng.normal(0, position_sigma, position.shape)
    noise = Rotation.from_rotvec(rng.normal(0, rotation_sigma, (rotation.size // 9, 3)))
    rotation = noise.as_matrix().reshape(rotation.shape) @ rotation
    sphere = Body.sphere(2 * RADIUS, 1150.0, 0.4)
    return PoseData(
        shots=np.arange(1, shots + 1),
        times_s=times,
        position=position,
        position_sigma=np.full(position.shape, position_sigma),
        rotation=rotation,
        rotation_sigma=np.full(rotation.shape[:3], rotation_sigma),
        bodies=(sphere, sphere),
        gravity=9.80665,
        air_density=1.2,
        covariates={"order": np.linspace(-0.5, 0.5, shots)},
        camera=CAMERA,
    )


def _time_in_reach(position: Floats, tau: Floats) -> Floats:
    """Return the displacement of a unit force within REACH, s^2, shape (shots, frames, 1)."""
    gap = np.linalg.norm(position[:, :, 1] - position[:, :, 0], axis=-1)[..., None] - 2 * RADIUS
    away = np.abs(tau)
    within = np.minimum(away, away * REACH / np.maximum(gap, 1e-9))
    return within * (away - within / 2)


def collided(
    velocity: Floats,
    spin: Floats,
    normal: Floats,
    law: tuple[float, float, float],
    slope: float = 0.0,
) -> tuple[Floats, Floats]:
    """Return velocities and spins after contact, shape (shots, 2, 3), shot by shot in scalars."""
    e0, mu, beta0 = law
    velocity, spin = velocity.copy(), spin.copy()
    for s, n in enumerate(normal):
        relative = velocity[s, 1] - velocity[s, 0]
        v_n = -float(relative @ n)
        e = e0 * (1 - slope * (v_n**0.2 - 2**0.2) / 0.2)
        surface = relative + v_n * n + RADIUS * np.cross(n, spin[s].sum(axis=0))
        v_s = float(np.linalg.norm(surface))
        along = surface / v_s
        v_s_after = max(-beta0 * v_s, v_s - mu * (1 + e) * 3.5 * v_n)
        # Of a change of surface velocity 2/7 is translation, 5/7 is spin, for solid spheres.
        change = (e + 1) * v_n * n + (v_s_after - v_s) * 2 / 7 * along
        velocity[s, 1] += change / 2
        velocity[s, 0] -= change / 2
        spin[s] += np.cross((v_s_after - v_s) * 5 / 7 * along, n) / (2 * RADIUS)
    return velocity, spin
