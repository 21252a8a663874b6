"""Coefficients of single shots, and a report's mean e, against the world's own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.arrays import Floats
from analysis.model.data.poses import PoseData
from analysis.results.campaign import mean_restitution
from analysis.results.from_poses import pose_impacts
from analysis.results.ratios import ratios
from simulators.challenge.bodies import Bodies
from simulators.challenge.encounter import collide
from simulators.challenge.flight import acceleration
from simulators.challenge.launch import draw_settings, draw_touch
from simulators.challenge.nature import Nature
from simulators.world.description import Environment, Sphere

SCALE, DRAG = 0, 1
"""Rows of what all shots of a campaign share."""
SPEEDS = {"v_n": 0, "v_n'": 2}
"""In which column of the velocities they stand."""


def true_speeds(nature: Nature, seed: int, shots: int) -> Floats:
    """Return v_n and v_n' of a fired campaign, m/s, shape (S, 2).

    Along the normal at first touch, signs as section 7.1 has them. The launch is drawn once more,
    and the world's own contact integrated.
    """
    launch = np.random.default_rng([seed, 0])
    sphere = Sphere()
    settings = draw_settings(shots, launch)
    touch = draw_touch(settings, sphere, launch)
    air = acceleration(nature, Bodies.of(sphere, nature), Environment())
    passage = collide(nature, settings, touch, air)
    leaving = passage.velocity[:, 1] - passage.velocity[:, 0]
    return np.stack([-touch.approach, (leaving * touch.normal).sum(axis=1)], axis=1)


def of_single_shots(data: PoseData, nature: Nature, seed: int, shared: Floats) -> dict[str, Floats]:
    """Return own and total pulls of v_n, v_n' and e, and the total pull of the mean e.

    Parameters
    ----------
    shared
        By how many stated errors scale and drag of this campaign are off, shape (2,).
    """
    impacts = pose_impacts(data)
    assert impacts.shared is not None
    true = true_speeds(nature, seed, len(data.shots))[np.searchsorted(data.shots, impacts.shots)]
    velocities = impacts.velocities.copy()
    velocities[:, list(SPEEDS.values())] = true
    done = shared[SCALE] * impacts.shared[:, SCALE] + shared[DRAG] * impacts.shared[:, DRAG]
    exact, freed = (replace(impacts, velocities=v) for v in (velocities, impacts.velocities - done))
    pulls = {}
    spread = np.sqrt(np.diagonal(impacts.covariance, axis1=1, axis2=2))
    for name, k in SPEEDS.items():
        variance = impacts.covariance[:, k, k] - (impacts.shared[:, :2, k] ** 2).sum(axis=1)
        own = (freed.velocities - exact.velocities)[:, k] / np.sqrt(variance)
        pulls[f"{name} of a shot, own"] = own
        pulls[f"{name} of a shot, total"] = (impacts.velocities - velocities)[:, k] / spread[:, k]
    measured, right, apart = (ratios(each).e for each in (impacts, exact, freed))
    pulls["e of a shot, own"] = (apart.value - right.value) / measured.own
    pulls["e of a shot, total"] = (measured.value - right.value) / measured.sigma
    every = np.ones(len(impacts.shots), dtype=np.bool_)
    mean, mean_right = (mean_restitution(each, every) for each in (impacts, exact))
    pulls["mean e of a report"] = np.array([(mean.value - mean_right.value) / mean.sigma])
    return pulls
