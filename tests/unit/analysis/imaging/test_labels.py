import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from scipy import ndimage

from analysis.imaging.edge.labels import label_connected

EIGHT = np.ones((3, 3))
masks = array_shapes(min_dims=2, max_dims=2, max_side=14).flatmap(
    lambda shape: arrays(np.bool_, shape, elements=st.booleans())
)


def in_order_of_first_pixels(labels: np.ndarray) -> np.ndarray:
    _, first = np.unique(labels[labels > 0], return_index=True)
    rank = np.zeros(labels.max(initial=0) + 1, dtype=np.int64)
    rank[1:] = first.argsort().argsort() + 1
    return rank[labels]


def picture(*rows: str) -> np.ndarray:
    return np.array([[c == "#" for c in row] for row in rows])


@settings(max_examples=150, deadline=None)
@given(mask=masks)
def test_components_are_those_of_scipy_with_eight_neighbours(mask: np.ndarray) -> None:
    expected, _ = ndimage.label(mask, EIGHT)
    np.testing.assert_array_equal(label_connected(mask), in_order_of_first_pixels(expected))


@pytest.mark.parametrize("density", [0.2, 0.4, 0.6])
def test_a_whole_frame_of_random_pixels_agrees_too(density: float) -> None:
    mask = np.random.default_rng(7).random((96, 120)) < density
    expected, _ = ndimage.label(mask, EIGHT)
    np.testing.assert_array_equal(label_connected(mask), in_order_of_first_pixels(expected))


@pytest.mark.parametrize(
    "mask",
    [
        picture("#...#", "#...#", "#####"),
        picture("#.#.#", "#.#.#", "#####"),
        picture("....#", "...#.", "#.#..", ".#..."),
        picture("..#..", ".#.#.", "#...#", ".#.#.", "..#.."),
        picture("#####", "....#", "###.#", "#.#.#", "#...#", "#####"),
    ],
    ids=["U", "W", "check mark", "diamond", "spiral"],
)
def test_arms_that_meet_only_further_down_are_one_curve(mask: np.ndarray) -> None:
    labels = label_connected(mask)
    assert set(labels[mask].tolist()) == {1}
    assert not labels[~mask].any()


def test_an_empty_mask_has_no_curve() -> None:
    assert not label_connected(np.zeros((5, 6), dtype=np.bool_)).any()
