"""A line with errors in both coordinates, against published numbers and against orthogonality."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.results.campaign import york_line

# Points: K. Pearson, Phil. Mag. 2, 559 (1901). Weights: D. York, Can. J. Phys. 44, 1079 (1966).
PEARSON_X = np.array([0.0, 0.9, 1.8, 2.6, 3.3, 4.4, 5.2, 6.1, 6.5, 7.4])
PEARSON_Y = np.array([5.9, 5.4, 4.4, 4.6, 3.5, 3.7, 2.8, 2.8, 2.4, 1.5])
YORK_X = np.array([1000, 1000, 500, 800, 200, 80, 60, 20, 1.8, 1.0])
YORK_Y = np.array([1, 1.8, 4, 8, 20, 20, 70, 70, 100, 500.0])


def test_pearsons_points_with_yorks_weights_give_the_published_line() -> None:
    line = york_line(PEARSON_X, PEARSON_Y, YORK_X**-0.5, YORK_Y**-0.5, np.zeros(10))
    assert line is not None
    assert line.slope == pytest.approx(-0.480533407, abs=1e-9)
    assert line.intercept == pytest.approx(5.47991022, abs=1e-8)
    assert np.sqrt(line.covariance[0, 0]) == pytest.approx(0.0579850, abs=1e-6)
    assert np.sqrt(line.covariance[1, 1]) == pytest.approx(0.2949707, abs=1e-6)
    assert line.chi2 / line.freedom == pytest.approx(1.4832942, abs=1e-6)


def test_without_errors_in_x_it_is_weighted_least_squares() -> None:
    rng = np.random.default_rng(3)
    x, sigma = np.linspace(0, 4, 9), rng.uniform(0.1, 0.4, 9)
    y = 1.5 - 0.3 * x + rng.normal(0, sigma)
    line = york_line(x, y, np.zeros(9), sigma, np.zeros(9))
    fitted, covariance = np.polyfit(x, y, 1, w=1 / sigma, cov="unscaled")
    assert line is not None
    assert (line.slope, line.intercept) == pytest.approx(tuple(fitted))
    np.testing.assert_allclose(line.covariance, covariance)
    np.testing.assert_allclose(
        line.sigma_at(x),
        np.sqrt(covariance[0, 0] * x**2 + 2 * covariance[0, 1] * x + covariance[1, 1]),
    )


@given(st.floats(-1.2, 1.2), st.integers(0, 10_000))
def test_with_like_errors_it_turns_with_the_points(angle: float, seed: int) -> None:
    """Equal, uncorrelated errors make it orthogonal regression, which knows no axes."""
    rng = np.random.default_rng(seed)
    along, across = rng.uniform(-5, 5, 12), rng.normal(0, 0.1, 12)
    x = along * np.cos(angle) - across * np.sin(angle)
    y = along * np.sin(angle) + across * np.cos(angle)
    line = york_line(x, y, np.full(12, 0.1), np.full(12, 0.1), np.zeros(12))
    _, _, axes = np.linalg.svd(np.stack([x - x.mean(), y - y.mean()], axis=1))
    assert line is not None
    assert line.slope == pytest.approx(axes[0, 1] / axes[0, 0], rel=1e-6, abs=1e-9)
    assert line.at(np.array(x.mean())) == pytest.approx(y.mean(), abs=1e-9)


def test_pulls_have_unit_width_where_errors_are_correlated() -> None:
    rng = np.random.default_rng(11)
    true, pulls = np.linspace(0, 5, 15), []
    for _ in range(300):
        sx, sy, r = rng.uniform(0.1, 0.4, 15), rng.uniform(0.1, 0.4, 15), rng.uniform(-0.8, 0.8, 15)
        first, second = rng.normal(size=(2, 15))
        x = true + sx * first
        y = 2 - 0.5 * true + sy * (r * first + np.sqrt(1 - r**2) * second)
        line = york_line(x, y, sx, sy, r)
        assert line is not None
        off = np.array([line.slope + 0.5, line.intercept - 2])
        pulls.append(off / np.sqrt(np.diag(line.covariance)))
    width = np.std(pulls, axis=0)
    np.testing.assert_allclose(width, 1, atol=4 / np.sqrt(600))
    np.testing.assert_allclose(np.mean(pulls, axis=0), 0, atol=4 / np.sqrt(300))


def test_points_that_tell_no_line_give_none() -> None:
    two, same = np.array([0.0, 1.0]), np.ones(5)
    assert york_line(two, two, two, two + 1, two) is None
    assert york_line(same, np.arange(5.0), same, same, 0 * same) is None
