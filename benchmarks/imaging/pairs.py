"""Rotation between two frames: its error, and whether markers are mixed up.

One view of a sphere with 16 markers, as the rig's have. The first frame's pose is fitted from
near; the second's orientation is looked for without any hint.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.motion.rotation import rotation_matrix, rotation_vector
from analysis.photometric.follow.orientation_search import search_orientation, turns
from analysis.photometric.render.pose import fit_pose
from analysis.photometric.render.sight import Stance
from benchmarks.imaging.drawing import LIMITS, RADIUS, SIZE, drawn, fitted, sight_of, with_noise
from benchmarks.imaging.goals import Sheet
from simulators.world.markers import scatter_markers

Floats = NDArray[np.float64]

NOISE, MARKERS, STEP_DEG, FURTHEST_DEG, MIXED_UP_DEG = 2.0, 16, 6.0, 30.0, 3.0


def run(pairs: int, seed: int) -> None:
    """Measure pairs 6 degrees apart, and pairs up to 30 degrees apart."""
    sheet, rng = Sheet("pairs"), np.random.default_rng(seed)
    print(f"\n{pairs} pairs of frames of {MARKERS} markers, noise {NOISE:g}")
    found = np.array([one_pair(STEP_DEG, rng) for _ in range(pairs)])
    good = found[found[:, 0] < MIXED_UP_DEG]
    sheet.at_most("6 degrees apart: error", float(np.sqrt((good[:, 0] ** 2).mean())), 0.13, "deg")
    sheet.at_most("6 degrees apart: angle's bias", abs(float(good[:, 1].mean())), 0.02, "deg")
    wide = np.array([one_pair(rng.uniform(0.0, FURTHEST_DEG), rng) for _ in range(pairs)])
    both = np.concatenate([found, wide])
    certain = both[:, 2] > 0.0
    mixed = int((both[certain, 0] >= MIXED_UP_DEG).sum())
    sheet.at_most(f"up to 30 degrees apart: mixed up of {2 * pairs}", mixed, 0.0)
    sheet.at_most("left out, as another turn fits as well", float((~certain).sum()), 0.01 * pairs)
    sheet.write()


def one_pair(angle_deg: float, rng: np.random.Generator) -> tuple[float, float, bool]:
    """Return a pair's error of rotation, all three axes, and of its angle, degrees.

    And whether no other turn of the second frame fits as well.
    """
    pattern, axis = scatter_markers(MARKERS, rng), rng.normal(size=3)
    turn = rotation_matrix(np.radians(angle_deg) * axis / np.linalg.norm(axis))
    poses, certain = [], True
    for rotation, known in ((np.eye(3), True), (turn, False)):
        place = SIZE / 2 + rng.uniform(-0.5, 0.5, 2)
        image = with_noise(drawn(place, pattern @ rotation.T), NOISE, rng)
        sight = sight_of(image, pattern, float(np.hypot(NOISE, 12**-0.5)))
        if known:
            stance, _ = fitted(sight, place, rotation)
        else:
            centre = np.array([*(place + 0.2) / RADIUS, 0.0])
            start = Stance(centre, np.eye(3), np.array([[0.0, 1.0, 0.0, 0.0]]))
            found = search_orientation(sight, start, turns())
            stance, certain = found.stance, found.certain
            fit_pose(sight, stance, LIMITS, np.zeros((6, 6)))
        poses.append(stance.rotation)
    between = poses[1] @ poses[0].T
    error = math.degrees(float(np.linalg.norm(rotation_vector(between @ turn.T))))
    angle = math.degrees(float(np.linalg.norm(rotation_vector(between))))
    return error, angle - angle_deg, certain
