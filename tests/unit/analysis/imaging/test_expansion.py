import drawings
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.imaging.edge.edges import laplacian_of_gaussian
from analysis.imaging.edge.expansion import expand, expanded_zero_crossings, sample_offsets
from analysis.imaging.edge.facet import edge_points


@given(
    coefficients=st.lists(st.floats(-3, 3), min_size=9, max_size=9),
    samples=st.sampled_from([1, 2, 3, 4]),
)
def test_a_biquadratic_is_expanded_to_its_own_values(
    coefficients: list[float], samples: int
) -> None:
    c = np.array(coefficients).reshape(3, 3)
    row, column = np.mgrid[:5, :6].astype(float)
    fine_row, fine_column = (np.mgrid[: 5 * samples, : 6 * samples] + 0.5) / samples - 0.5
    inner = np.s_[samples:-samples, samples:-samples]
    expected = np.polynomial.polynomial.polyval2d(fine_row - 2, fine_column - 3, c)
    found = expand(np.polynomial.polynomial.polyval2d(row - 2, column - 3, c), samples)
    np.testing.assert_allclose(found[inner], expected[inner], atol=1e-9)


@pytest.mark.parametrize("samples", [3, 4])
def test_the_samples_of_a_pixel_are_as_far_apart_as_those_of_two_pixels(samples: int) -> None:
    offsets = sample_offsets(samples)
    both = np.concatenate([offsets, offsets + 1.0])
    np.testing.assert_allclose(np.diff(both), 1.0 / samples)
    assert offsets.mean() == pytest.approx(0.0)


def test_no_sample_at_all_is_refused() -> None:
    with pytest.raises(ValueError, match="at least 1"):
        sample_offsets(0)


@pytest.mark.parametrize("samples", [3, 4])
def test_crossings_lie_on_the_fine_grid_within_half_a_sample_of_the_limb(samples: int) -> None:
    place = (45.3, 60.7, 20.0)
    edges = laplacian_of_gaussian(drawings.draw([place]), 2.0)
    points = expanded_zero_crossings(edges, 4.0, samples)
    grid = (points.row + 0.5) * samples - 0.5
    np.testing.assert_allclose(grid, np.rint(grid), atol=1e-9)
    exact = edge_points(edges, 4.0)
    limb = np.hypot(exact.row - place[0], exact.column - place[1]).mean()
    off = np.hypot(points.row - place[0], points.column - place[1]) - limb
    assert np.abs(off).max() < 0.75 / samples
    assert off.mean() == pytest.approx(0.0, abs=0.03)


def test_finer_samples_leave_less_rounding() -> None:
    place = (45.3, 60.7, 20.0)
    edges = laplacian_of_gaussian(drawings.draw([place]), 2.0)
    spread = []
    for samples in (1, 3, 4):
        points = expanded_zero_crossings(edges, 4.0, samples)
        spread.append(np.std(np.hypot(points.row - place[0], points.column - place[1])))
    assert spread[0] > 2 * spread[1] > 2 * spread[2]
