import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.motion.velocity import fit_lines


@given(st.integers(2, 30), st.integers(0, 2**32 - 1))
def test_lines_through_correlated_values_are_those_of_generalised_least_squares(
    points: int, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    tau, values = np.sort(rng.normal(size=points)), rng.normal(size=(2, points))
    root = rng.normal(size=(points, points))
    spread = root @ root.T + np.eye(points)
    design = np.stack([np.ones(points), tau], 1)
    weight = np.linalg.inv(spread)
    inverse = np.linalg.inv(design.T @ weight @ design)
    lines, covariance, products = fit_lines(tau, values, spread.copy())
    largest = float(np.abs(inverse).max())
    np.testing.assert_allclose(covariance, inverse, rtol=1e-6, atol=1e-9 * largest)
    expected = values @ weight @ design @ inverse
    left = values - expected @ design.T
    np.testing.assert_allclose(lines, expected, rtol=1e-6, atol=1e-8 * largest)
    np.testing.assert_allclose(products, left @ weight @ left.T, rtol=1e-6, atol=1e-8 * largest)


def test_a_line_needs_two_times_and_errors_of_their_own() -> None:
    with pytest.raises(ValueError, match="no slope"):
        fit_lines(np.ones(3), np.ones((1, 3)), np.eye(3))
    with pytest.raises(ValueError, match="must be positive"):
        fit_lines(np.arange(3.0), np.ones((1, 3)), np.ones((3, 3)))
