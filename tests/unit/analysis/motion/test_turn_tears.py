"""Orientations that contradict each other, of spheres whose true turning is known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from analysis.arrays import Floats
from analysis.motion.tears import LEAST_IN_ONE_VIEW, agreeing_turns

TIMES = np.arange(60) * 5e-4
RATE = np.array([30.0, -40.0, 20.0])
SIGMA = 0.005


def turning(rng: np.random.Generator) -> Rotation:
    true = Rotation.from_rotvec(RATE * TIMES[:, None]) * Rotation.from_rotvec([0.3, 0.1, -0.2])
    return Rotation.from_rotvec(SIGMA * rng.standard_normal((60, 3))) * true


def agreeing(turns: Rotation) -> Floats:
    return np.flatnonzero(agreeing_turns(TIMES, turns.as_matrix(), np.full(60, SIGMA)))


def test_noise_alone_contradicts_nothing() -> None:
    rng = np.random.default_rng(1)
    for _ in range(30):
        assert len(agreeing(turning(rng))) == 60


@pytest.mark.parametrize("wrong", [12, 25])
def test_a_run_that_took_other_markers_is_left_out(wrong: int) -> None:
    turns = turning(np.random.default_rng(2))
    jumped = Rotation.concatenate(
        [turns[: 60 - wrong], Rotation.from_rotvec([0.4, 0.0, 0.5]) * turns[60 - wrong :]]
    )
    assert agreeing(jumped).tolist() == list(range(60 - wrong))


def test_in_one_view_orientations_that_a_quarter_contradicts_are_none() -> None:
    """What agrees may be the wrong run of the two: the outcome is as smooth either way."""
    turns = turning(np.random.default_rng(2))
    jumped = Rotation.concatenate([turns[:45], Rotation.from_rotvec([0.4, 0.0, 0.5]) * turns[45:]])
    seen = jumped.as_matrix(), np.full(60, SIGMA)
    assert agreeing_turns(TIMES, *seen).sum() == 45
    assert not agreeing_turns(TIMES, *seen, least=LEAST_IN_ONE_VIEW).any()


def test_orientations_of_which_no_half_agrees_are_none() -> None:
    rng = np.random.default_rng(3)
    every = Rotation.random(60, random_state=rng)
    assert len(agreeing(every)) == 0


def test_three_orientations_without_a_common_rate_are_none() -> None:
    turns = Rotation.random(3, random_state=1).as_matrix()
    assert not agreeing_turns(TIMES[:3], turns, np.full(3, SIGMA)).any()


def test_two_orientations_do_not_outvote_those_that_contradict_them() -> None:
    turns = turning(np.random.default_rng(4)).as_matrix()
    others = Rotation.random(2, random_state=2).as_matrix()
    four = np.stack([turns[0], turns[1], *others])
    assert not agreeing_turns(TIMES[:4], four, np.full(4, SIGMA)).any()


def test_three_orientations_of_one_rate_all_count() -> None:
    turns = turning(np.random.default_rng(5)).as_matrix()[:3]
    assert agreeing_turns(TIMES[:3], turns, np.full(3, SIGMA)).all()


def test_orientations_that_agree_but_for_whole_turns_in_between_are_none() -> None:
    """Each third frame agrees with a slow rate as well as with the true one; the other tells."""
    frames = np.array([0, 2, 3, 6])
    turns = Rotation.from_rotvec((2 * np.pi / 3 + 0.1) * frames[:, None] * [0.0, 0.6, 0.8])
    assert not agreeing_turns(TIMES[frames], turns.as_matrix(), np.full(4, SIGMA)).any()
