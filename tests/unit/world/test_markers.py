import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from simulators.world.markers import scatter_markers


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10_000), number=st.integers(2, 18))
def test_no_two_markers_are_closer_than_told(seed: int, number: int) -> None:
    directions = scatter_markers(number, np.random.default_rng(seed), separation_rad=0.55)
    assert directions.shape == (number, 3)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0)
    first, second = np.triu_indices(number, k=1)
    between = np.arccos(np.einsum("ij,ij->i", directions[first], directions[second]))
    assert between.min() >= 0.55


def test_the_same_seed_scatters_the_same_markers() -> None:
    one, other = (scatter_markers(16, np.random.default_rng(5)) for _ in range(2))
    np.testing.assert_array_equal(one, other)


def test_too_many_markers_are_refused_with_the_way_out() -> None:
    # Caps of half the separation would cover more than the sphere.
    with pytest.raises(ValueError, match=r"60 markers do not fit.*take fewer"):
        scatter_markers(60, np.random.default_rng(0), separation_rad=0.55)


def test_no_markers_make_a_plain_sphere() -> None:
    assert scatter_markers(0, np.random.default_rng(0)).shape == (0, 3)
