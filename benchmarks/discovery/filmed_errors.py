"""Errors as films leave them, laid on true poses: fresh, slow, and shared by a whole campaign.

What all flights share is the same all over the field, or changes with the place of a sphere in it:
a light that is not quite as learned does either. A learned pattern of markers is off its sphere.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from analysis.model.data.poses import PoseData
from analysis.setup import SlowErrors
from benchmarks.discovery.campaigns import posed
from benchmarks.discovery.lasting import RIG_NOISE
from simulators.challenge.camera import OPTICS
from simulators.challenge.campaign import Noise, run_campaign
from simulators.challenge.nature import Nature
from simulators.world.description import Sphere

Floats = NDArray[np.float64]

UNSEEN = Noise(1e-9, 1e-9)
SHARED_PX, SCALE, MEMORY_RAD = 0.002, 1e-3, 0.32
TURN_PER_CENTRE_ERROR = 1.5
FRAMES = 60
SHORTEST_S = 1e-3
COURSE_M = 0.03
"""Over which what all flights share changes where it changes at all: half of a slow flight."""
WAVES = 12


def filmed(
    nature: Nature,
    seed: int,
    shots: int,
    slow_px: float,
    scale_pull: float | None = None,
    *,
    by_place: bool = False,
) -> PoseData:
    """Return poses with errors drawn from what is stated of them.

    Parameters
    ----------
    slow_px
        Size of the slow error of an outline's place, px. It forgets itself exponentially while a
        sphere turns by what its markers are wide.
    scale_pull
        By how many stated errors lengths are seen too long; None: drawn.
    by_place
        Whether what all flights share changes with the place in the field.
    """
    rng = np.random.default_rng([seed, 7])
    true = posed(run_campaign(nature, seed, shots=shots, frames=FRAMES, noise=UNSEEN))
    px = 1.0 / OPTICS.scale_px_per_m
    slow = SlowErrors(
        position_m=slow_px * px,
        rotation_rad=TURN_PER_CENTRE_ERROR * slow_px * px / Sphere().radius_m,
        shared_m=SHARED_PX * px,
        scale=SCALE,
        memory_rad=MEMORY_RAD,
    )
    places, turns = _drawn(true, slow, rng)
    apart = np.sqrt(2.0) * slow.shared_m * rng.normal(size=3) * np.array([[-0.5], [0.5]])
    scale = 1.0 + SCALE * (rng.normal() if scale_pull is None else scale_pull)
    seen = Rotation.from_rotvec(slow.common_rad * rng.normal(size=(2, 3))).as_matrix()
    if by_place:
        apart = slow.shared_m * _over_field(true.position, rng)
        turn = slow.common_rad * _over_field(true.position, rng)
        seen = Rotation.from_rotvec(turn.reshape(-1, 3)).as_matrix().reshape(true.rotation.shape)
    # The learned pattern of markers off its sphere, fixed in each body.
    pattern = slow.common_m * rng.normal(size=(2, 3, 1))
    held = (true.rotation @ pattern)[..., 0]
    position = scale * true.position + apart + held + places
    turned = Rotation.from_rotvec(turns.reshape(-1, 3)).as_matrix().reshape(true.rotation.shape)
    return replace(
        true,
        position=position,
        rotation=turned @ seen @ true.rotation,
        position_sigma=np.full(position.shape, RIG_NOISE.centre_px * px),
        rotation_sigma=np.full(true.rotation_sigma.shape, RIG_NOISE.rotation_rad),
        slow=slow,
        own_slow={},
    )


def _over_field(places: Floats, rng: np.random.Generator) -> Floats:
    """Return three smooth functions of the place for each sphere, of size 1, at places (..., 2, 3).

    Sums of waves in all directions, correlated as exp(-(distance / COURSE_M)^2 / 2).
    """
    waves = rng.normal(0.0, 1.0 / COURSE_M, (2, 3, WAVES, 3))
    phases = rng.uniform(0.0, 2.0 * np.pi, (2, 3, WAVES))
    along = np.einsum("...sk,scwk->...scw", places, waves) + phases
    return np.asarray(np.sqrt(2.0 / WAVES) * np.cos(along).sum(axis=-1))


def _drawn(true: PoseData, slow: SlowErrors, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Return errors of places, m, and of turns, rad, shape (S, F, 2, 3), fresh and slow."""
    shape = true.position.shape
    places = RIG_NOISE.centre_px / OPTICS.scale_px_per_m * rng.normal(size=shape)
    turns = RIG_NOISE.rotation_rad * rng.normal(size=shape)
    for shot, sphere in np.ndindex(shape[0], 2):
        times, rotation = true.times_s[shot], true.rotation[shot, :, sphere]
        steps = Rotation.from_matrix(rotation[1:] @ rotation[:-1].swapaxes(1, 2)).magnitude()
        turned = np.concatenate([[0.0], np.cumsum(steps)]) / MEMORY_RAD
        turned = np.minimum(turned, (times - times[0]) / SHORTEST_S)
        lasting = np.exp(-np.abs(turned[:, None] - turned)) + 1e-9 * np.eye(len(times))
        root = np.linalg.cholesky(lasting)
        places[shot, :, sphere] += slow.position_m * root @ rng.normal(size=(len(times), 3))
        turns[shot, :, sphere] += slow.rotation_rad * root @ rng.normal(size=(len(times), 3))
    return places, turns
