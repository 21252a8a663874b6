import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from analysis.motion.proximal import MOST_GUESSES, assign, match_markers, proximal_uniformity

costs = array_shapes(min_dims=2, max_dims=2, min_side=0, max_side=7).flatmap(
    lambda shape: arrays(np.float64, shape, elements=st.floats(0, 10))
)
START = np.array([[-8.0, -6.0], [2.0, -9.0], [9.0, 1.0], [-3.0, 8.0]])
STEP = np.array([[1.5, 0.5], [1.4, 0.9], [1.2, 0.4], [1.6, 0.7]])


def moved(k: int) -> np.ndarray:
    return START + k * STEP


def in_order(rng: np.random.Generator, k: int) -> tuple[np.ndarray, np.ndarray]:
    order = rng.permutation(len(START))
    return moved(k)[order], order


@given(cost=costs)
def test_no_candidate_is_given_twice_and_none_is_left_that_could_be_given(
    cost: np.ndarray,
) -> None:
    chosen = assign(cost)
    given_away = chosen[chosen >= 0]
    assert chosen.shape == (cost.shape[0],)
    assert np.unique(given_away).size == given_away.size == min(cost.shape)


def test_each_point_takes_the_candidate_that_is_clearly_its_own() -> None:
    cost = np.array([[0.1, 5.0, 6.0], [5.0, 7.0, 0.2], [4.0, 0.3, 5.0]])
    assert assign(cost).tolist() == [0, 2, 1]


def test_of_two_points_with_one_candidate_the_nearer_has_it() -> None:
    assert assign(np.array([[2.0], [0.5]])).tolist() == [-1, 0]


def test_the_cost_is_the_change_of_step_and_the_step_as_shares_of_their_sums() -> None:
    before = np.array([[0.0, 0.0], [10.0, 0.0]])
    now = np.array([[1.0, 0.0], [10.0, 1.0]])
    following = np.array([[2.0, 0.0], [10.0, 3.0]])
    change = np.array([[0.0, np.hypot(8, 3)], [np.hypot(8, 2), 1.0]])
    length = np.array([[1.0, np.hypot(9, 3)], [np.hypot(8, 1), 2.0]])
    np.testing.assert_allclose(
        proximal_uniformity(before, now, following),
        change / change.sum() + length / length.sum(),
    )


@pytest.mark.parametrize("seed", range(4))
def test_smooth_motion_keeps_every_name(seed: int) -> None:
    rng = np.random.default_rng(seed)
    frames, orders = zip(*(in_order(rng, k) for k in range(10)), strict=True)
    names = match_markers(list(frames), reach_px=5.0)
    called = {int(marker): int(name) for marker, name in zip(orders[0], names[0], strict=True)}
    for order, given_names in zip(orders, names, strict=True):
        assert given_names.tolist() == [called[int(marker)] for marker in order]


@pytest.mark.parametrize("hidden", [1, MOST_GUESSES])
def test_a_marker_hidden_for_up_to_two_frames_comes_back_under_its_name(hidden: int) -> None:
    frames = [moved(k) if not 4 <= k < 4 + hidden else moved(k)[:3] for k in range(9)]
    names = match_markers(frames, reach_px=5.0)
    assert [n.tolist() for n in names] == [list(range(len(frame))) for frame in frames]


def test_a_marker_hidden_for_longer_is_forgotten_and_gets_a_name_of_its_own() -> None:
    hidden = MOST_GUESSES + 1
    frames = [moved(k) if not 4 <= k < 4 + hidden else moved(k)[:3] for k in range(10)]
    names = match_markers(frames, reach_px=5.0)
    assert names[-1].tolist() == [0, 1, 2, 4]


def test_a_marker_that_comes_round_the_limb_gets_a_fresh_name() -> None:
    frames = [moved(k)[: 3 if k < 5 else 4] for k in range(8)]
    names = match_markers(frames, reach_px=5.0)
    assert names[4].tolist() == [0, 1, 2]
    assert names[7].tolist() == [0, 1, 2, 3]


def test_nothing_is_matched_beyond_its_reach() -> None:
    names = match_markers([START[:1], START[:1] + 6.0], reach_px=5.0)
    assert [n.tolist() for n in names] == [[0], [1]]


def test_no_frames_and_empty_frames_have_no_names() -> None:
    assert match_markers([], 5.0) == []
    names = match_markers([np.zeros((0, 2)), START[:1], np.zeros((0, 2))], 5.0)
    assert [n.tolist() for n in names] == [[], [0], []]
