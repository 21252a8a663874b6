import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares

from analysis.imaging.ellipse_shells import fit_ellipse
from analysis.imaging.shells import Circle, fit_circles, share_out

UNKNOWN = np.zeros((3, 3))


def arc(row: float, column: float, radius: float, angles: np.ndarray) -> tuple[np.ndarray, ...]:
    return row + radius * np.cos(angles), column + radius * np.sin(angles)


def start(row: float, column: float, radius: float) -> Circle:
    return Circle(row, column, radius, UNKNOWN)


@settings(max_examples=60, deadline=None)
@given(
    row=st.floats(-50, 250),
    column=st.floats(-50, 250),
    radius=st.floats(6, 60),
    begin=st.floats(0, 2 * math.pi),
    length=st.floats(2.0, 2 * math.pi),
    aside=st.floats(0, 2 * math.pi),
)
def test_exact_points_on_an_arc_give_their_circle(
    row: float, column: float, radius: float, begin: float, length: float, aside: float
) -> None:
    points = arc(row, column, radius, begin + np.linspace(0, length, 60))
    away = 0.1 * radius
    guess = start(row + away * math.cos(aside), column + away * math.sin(aside), 0.95 * radius)
    (circle,), u = fit_circles(*points, [guess], iterations=100)
    found = (circle.row, circle.column, circle.radius)
    np.testing.assert_allclose(found, (row, column, radius), atol=2e-3)
    np.testing.assert_allclose(u, 1.0)


@pytest.mark.parametrize("length", [2.5, 2 * math.pi])
def test_noisy_points_give_the_least_squares_circle_of_scipy(length: float) -> None:
    rng = np.random.default_rng(3)
    row, column = arc(40.0, 50.0, 20.0, np.linspace(0, length, 80))
    row, column = row + rng.normal(0, 0.2, 80), column + rng.normal(0, 0.2, 80)
    (circle,), _ = fit_circles(row, column, [start(41.0, 49.0, 19.0)], iterations=100)
    expected = least_squares(
        lambda p: np.hypot(row - p[0], column - p[1]) - p[2], [41.0, 49.0, 19.0]
    ).x
    np.testing.assert_allclose((circle.row, circle.column, circle.radius), expected, atol=2e-3)


def test_a_held_radius_is_kept_and_the_centre_found() -> None:
    points = arc(40.0, 50.0, 20.0, np.linspace(0, 2 * math.pi, 60, endpoint=False))
    (circle,), _ = fit_circles(*points, [start(42.0, 49.0, 20.5)], hold_radius=True)
    assert circle.radius == 20.5
    assert (circle.row, circle.column) == pytest.approx((40.0, 50.0), abs=1e-3)
    assert circle.covariance[2, 2] == 0.0


def test_guesses_in_whole_pixels_are_moved_by_fractions() -> None:
    points = arc(40.3, 49.6, 20.2, np.linspace(0, 2 * math.pi, 60, endpoint=False))
    (circle,), _ = fit_circles(*points, [start(41, 49, 19)], iterations=100)
    found = (circle.row, circle.column, circle.radius)
    np.testing.assert_allclose(found, (40.3, 49.6, 20.2), atol=2e-3)


def test_two_touching_circles_share_their_points_by_membership() -> None:
    angles = np.linspace(0, 2 * math.pi, 100, endpoint=False)
    truth = [(40.0, 40.0, 20.0), (52.0, 72.0, 14.176)]
    rows, columns = np.concatenate([arc(*circle, angles) for circle in truth], axis=1)
    guesses = [start(43.0, 37.0, 18.0), start(49.0, 74.0, 16.0)]
    found, u = fit_circles(rows, columns, guesses)
    for circle, expected in zip(found, truth, strict=True):
        np.testing.assert_allclose((circle.row, circle.column, circle.radius), expected, atol=5e-3)
    np.testing.assert_allclose(u.sum(axis=0), 1.0)
    assert (u[0, :100] > 0.5).mean() > 0.98
    assert (u[1, 100:] > 0.5).mean() > 0.98


@pytest.mark.parametrize("seed", range(5))
def test_the_noise_cluster_takes_forty_per_cent_of_outliers(seed: int) -> None:
    rng = np.random.default_rng(seed)
    row, column = arc(40.0, 50.0, 20.0, rng.uniform(0, 2 * math.pi, 120))
    row, column = row + rng.normal(0, 0.05, 120), column + rng.normal(0, 0.05, 120)
    strays = np.array([40.0, 50.0])[:, None] + rng.uniform(-30, 30, (2, 80))
    rows, columns = np.concatenate([row, strays[0]]), np.concatenate([column, strays[1]])
    guess = start(41.0, 49.5, 19.5)
    (held,), u = fit_circles(rows, columns, [guess], noise_distance=0.6)
    assert (held.row, held.column, held.radius) == pytest.approx((40.0, 50.0, 20.0), abs=0.03)
    far = np.abs(np.hypot(strays[0] - 40, strays[1] - 50) - 20) > 2.0
    assert u[0, 120:][far].max() < 0.1
    assert u[0, :120].min() > 0.8
    (loose,), _ = fit_circles(rows, columns, [guess])
    assert math.hypot(loose.row - 40, loose.column - 50) > 0.1


def memberships(radii: list[float], away: list[float], noise_distance: float) -> np.ndarray:
    """Return those of points on a line in circles about its beginning."""
    u = np.empty((len(radii), len(away)))
    state = np.array([(0.0, 0.0, radius) for radius in radii])
    share_out.py_func(np.array(away), np.zeros(len(away)), state, noise_distance, u)
    return u


def test_a_point_belongs_to_each_shell_by_the_inverse_square_of_its_distance() -> None:
    u = memberships([10.0, 12.0], [9.0, 11.0, 13.0, 14.0], math.inf)
    np.testing.assert_allclose(u, [[0.9, 0.5, 0.1, 0.2], [0.1, 0.5, 0.9, 0.8]], rtol=1e-6)


def test_the_noise_cluster_is_as_near_as_a_shell_at_its_distance() -> None:
    u = memberships([10.0], [10.0, 10.5, 11.0, 12.0], 0.5)
    np.testing.assert_allclose(u[0], [1.0, 0.5, 0.2, 1 / 17], rtol=1e-6)


@pytest.mark.parametrize(
    ("length", "noise", "noise_distance"),
    [(2.5, 0.1, None), (2 * math.pi, 0.1, None), (2 * math.pi, 0.04, 0.3)],
)
def test_the_covariance_is_that_of_three_hundred_noisy_fits(
    length: float, noise: float, noise_distance: float | None
) -> None:
    rng = np.random.default_rng(8)
    points = np.array(arc(40.0, 50.0, 20.0, np.linspace(0, length, 90)))
    guess = start(40.5, 49.5, 20.0)
    fits, stated = [], []
    for _ in range(300):
        row, column = points + rng.normal(0, noise, points.shape)
        (circle,), _ = fit_circles(row, column, [guess], noise_distance=noise_distance)
        fits.append((circle.row, circle.column, circle.radius))
        stated.append(circle.covariance)
    scatter, mean = np.cov(np.array(fits).T), np.mean(stated, axis=0)
    np.testing.assert_allclose(np.sqrt(np.diag(mean)), np.sqrt(np.diag(scatter)), rtol=0.15)
    tied = np.sqrt(np.outer(np.diag(scatter), np.diag(scatter)))
    np.testing.assert_allclose(mean / tied, scatter / tied, atol=0.2)


def ellipse_points(
    semi: tuple[float, float], angle: float, t: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return points (row, column) of an ellipse about (30, 40), its major axis at `angle`."""
    along, across = semi[0] * np.cos(t), semi[1] * np.sin(t)
    row = 30.0 + math.cos(angle) * along - math.sin(angle) * across
    return row, 40.0 + math.sin(angle) * along + math.cos(angle) * across


def between_axes(first: float, second: float) -> float:
    return abs((first - second + math.pi / 2) % math.pi - math.pi / 2)


@settings(max_examples=60, deadline=None)
@given(
    major=st.floats(3, 20),
    flatness=st.floats(0.45, 0.95),
    angle=st.floats(-1.5, 1.5),
    begin=st.floats(0, 6.28),
    length=st.floats(4.2, 6.2),
)
def test_exact_points_give_their_ellipse(
    major: float, flatness: float, angle: float, begin: float, length: float
) -> None:
    t = begin + np.linspace(0, length, 40)
    ellipse = fit_ellipse(*ellipse_points((major, flatness * major), angle, t), iterations=100)
    assert ellipse is not None
    expected = (30.0, 40.0, major, flatness * major)
    found = (ellipse.row, ellipse.column, ellipse.semi_major, ellipse.semi_minor)
    assert found == pytest.approx(expected, abs=1e-3)
    assert between_axes(ellipse.angle, angle) < 1e-3
    assert ellipse.rms_px < 1e-3


@pytest.mark.parametrize("seed", range(6))
def test_noisy_points_give_the_ellipse_of_opencv(seed: int) -> None:
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 2 * math.pi, 60, endpoint=False)
    row, column = ellipse_points((8.0, 5.0), 0.6, t)
    row, column = row + rng.normal(0, 0.05, 60), column + rng.normal(0, 0.05, 60)
    ellipse = fit_ellipse(row, column)
    assert ellipse is not None
    points = np.stack([column, row], 1).astype(np.float32)
    (x, y), diameters, degrees = cv2.fitEllipse(points)
    # OpenCV turns its first axis from x; ours turns from the row axis, which is OpenCV's y.
    assert (ellipse.row, ellipse.column) == pytest.approx((y, x), abs=0.02)
    assert sorted(diameters) == pytest.approx(
        [2 * ellipse.semi_minor, 2 * ellipse.semi_major], abs=0.05
    )
    major = math.radians(degrees + (90.0 if diameters[1] > diameters[0] else 0.0))
    assert between_axes(ellipse.angle, math.pi / 2 - major) < 0.02
    assert ellipse.rms_px == pytest.approx(0.05, rel=0.35)


def test_points_that_do_not_close_to_an_ellipse_give_none() -> None:
    t = np.linspace(-1, 1, 30)
    assert fit_ellipse(np.arange(5.0), np.arange(5.0) ** 2) is None
    assert fit_ellipse(np.full(30, 3.0), np.full(30, 4.0)) is None
    assert fit_ellipse(10 * np.sinh(2 * t), 10 * np.cosh(2 * t)) is None
