"""The slow error of a campaign's poses is found in its own flights, whatever the air does."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from analysis.motion.pattern import Orientations
from analysis.motion.poses import Centres
from analysis.motion.slow_evidence import Evidence
from analysis.photometric.learn.appearance import PRIOR_SLOW_PX
from analysis.photometric.slow_size import evidence_of, slow_size_px

Floats = NDArray[np.float64]
SCALE_PX_PER_M, RADIUS_PX, ALPHA = 1600.0, 20.0, 0.16
SPIN_RAD_PER_S = 40.0
LASTING_S = 2 * ALPHA / SPIN_RAD_PER_S
PLACE_M, TURN_RAD, G = 3e-6, 4e-4, 9.81
TURN_FOR_ONE_PX = 1.5 / RADIUS_PX
"""A marker's direction is off by this much where its outline is off by a pixel."""


def wandering(rng: np.random.Generator, times_s: Floats, size: float) -> Floats:
    """Return three errors that forget themselves exponentially, shape (frames, 3)."""
    values = [rng.normal(0.0, size, 3)]
    for step in np.diff(times_s):
        kept = np.exp(-step / LASTING_S)
        values.append(kept * values[-1] + rng.normal(0.0, size * np.sqrt(1 - kept**2), 3))
    return np.array(values)


def film(seed: int, slow_px: float, frames: int = 60, drag_per_m: float = 0.0) -> Evidence:
    """Return what a film of two spheres that part in its middle says."""
    rng, times = np.random.default_rng(seed), 1e-3 * np.arange(frames, dtype=np.float64)
    tau, half = times - times[frames // 2], frames // 2
    sides = ((0, half), (half, frames))
    centres, turns = [], []
    for sign in (1.0, -1.0):
        place, turned = np.empty((frames, 3)), np.empty((frames, 3, 3))
        for first, last in sides:
            own = slice(first, last)
            t, v = tau[own, None], sign * rng.normal(0.0, 1.0, 3)
            fallen = np.array([G, 0.0, 0.0])
            midway = v + fallen * t.mean()
            fall = fallen - drag_per_m * np.linalg.norm(midway) * midway
            place[own] = v * t + fall * t**2 / 2
            spin = SPIN_RAD_PER_S * np.array([0.6, 0.0, 0.8])
            turned[own] = Rotation.from_rotvec(spin * t).as_matrix()
        place += wandering(rng, times, slow_px / SCALE_PX_PER_M)
        place += rng.normal(0.0, PLACE_M, place.shape)
        off = wandering(rng, times, slow_px * TURN_FOR_ONE_PX)
        off += rng.normal(0.0, TURN_RAD, off.shape)
        centres.append(Centres(np.arange(frames), place, np.full(place.shape, PLACE_M)))
        turns.append(
            Orientations(
                frames=np.arange(frames),
                rotation=Rotation.from_rotvec(off).as_matrix() @ turned,
                covariance=np.tile(TURN_RAD**2 * np.eye(3), (frames, 1, 1)),
                pattern=np.zeros((0, 3)),
                matches=(),
                left_out={},
            )
        )
    outline = SCALE_PX_PER_M, RADIUS_PX, ALPHA
    pairs = (centres[0], centres[1]), (turns[0], turns[1])
    return evidence_of(*pairs, (times, G), sides, outline)


@pytest.mark.parametrize("slow_px", [0.0012, 0.004, 0.012])
def test_the_size_that_was_laid_on_the_poses_is_found(slow_px: float) -> None:
    found = slow_size_px([film(seed, slow_px) for seed in range(24)])
    assert found == pytest.approx(slow_px, rel=0.25)


def test_poses_that_only_scatter_have_less_than_was_believed() -> None:
    assert slow_size_px([film(seed, 0.0) for seed in range(24)]) < PRIOR_SLOW_PX / 2


def test_the_drag_of_the_air_is_no_slow_error() -> None:
    films = [film(seed, 0.0012, drag_per_m=0.05) for seed in range(24)]
    assert slow_size_px(films) == pytest.approx(0.0012, rel=0.25)


def test_without_flights_the_prior_stands() -> None:
    # Mean of the square of a lognormal: median^2 exp(2 ln(factor)^2).
    expected = PRIOR_SLOW_PX * np.exp(np.log(2.0) ** 2)
    assert slow_size_px([]) == pytest.approx(expected, rel=0.02)
    assert slow_size_px([film(1, 0.0012, frames=8)]) == pytest.approx(expected, rel=0.02)


def test_one_film_with_a_fault_of_its_own_does_not_speak_for_the_others() -> None:
    sound = [film(seed, 0.0012) for seed in range(11)]
    assert slow_size_px([*sound, film(99, 0.03)]) == pytest.approx(slow_size_px(sound), rel=0.1)
