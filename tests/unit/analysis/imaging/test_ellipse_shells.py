import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from analysis.imaging.ellipse_shells import fit_ellipse, fit_ellipses
from analysis.imaging.shells import Ellipse


def ring(ellipse: Ellipse, count: int = 80) -> np.ndarray:
    t = np.linspace(0, 2 * math.pi, count, endpoint=False)
    along, across = ellipse.semi_major * np.cos(t), ellipse.semi_minor * np.sin(t)
    c, s = math.cos(ellipse.angle), math.sin(ellipse.angle)
    return np.stack([ellipse.row + c * along - s * across, ellipse.column + s * along + c * across])


def round_guess(ellipse: Ellipse, off: float) -> Ellipse:
    radius = math.sqrt(ellipse.semi_major * ellipse.semi_minor)
    return Ellipse(ellipse.row + off, ellipse.column - off, radius, radius, 0.0, 0.0)


FIRST = Ellipse(30.0, 40.0, 14.0, 9.0, 0.5, 0.0)
SECOND = Ellipse(44.0, 62.0, 11.0, 8.0, -0.7, 0.0)


def assert_alike(found: Ellipse, truth: Ellipse, tolerance: float) -> None:
    for name in ("row", "column", "semi_major", "semi_minor"):
        assert getattr(found, name) == pytest.approx(getattr(truth, name), abs=tolerance), name
    turned = (found.angle - truth.angle + math.pi / 2) % math.pi - math.pi / 2
    assert abs(turned) < tolerance


def test_two_crossing_ellipses_are_told_apart_from_round_guesses() -> None:
    row, column = np.concatenate([ring(FIRST), ring(SECOND)], axis=1)
    fitted = fit_ellipses(row, column, [round_guess(FIRST, 1.0), round_guess(SECOND, -1.0)])
    assert fitted is not None
    for found, truth in zip(fitted[0], (FIRST, SECOND), strict=True):
        assert_alike(found, truth, 0.02)
    u = fitted[1]
    np.testing.assert_allclose(u.sum(axis=0), 1.0)
    assert (u[0, :80] > 0.5).mean() > 0.95
    assert (u[1, 80:] > 0.5).mean() > 0.95


@settings(max_examples=40, deadline=None)
@given(
    major=st.floats(6, 20),
    flatness=st.floats(0.5, 0.95),
    angle=st.floats(-1.5, 1.5),
    off=st.floats(-1.0, 1.0),
)
def test_one_shell_alone_is_the_single_fit(
    major: float, flatness: float, angle: float, off: float
) -> None:
    truth = Ellipse(30.0, 40.0, major, flatness * major, angle, 0.0)
    row, column = ring(truth)
    fitted = fit_ellipses(row, column, [round_guess(truth, off)])
    assert fitted is not None
    assert_alike(fitted[0][0], truth, 1e-3)
    np.testing.assert_allclose(fitted[1], 1.0)


@pytest.mark.parametrize("seed", range(4))
def test_without_strays_the_ellipse_is_that_of_opencv_and_strays_go_to_the_noise(
    seed: int,
) -> None:
    rng = np.random.default_rng(seed)
    row, column = ring(FIRST) + rng.normal(0, 0.05, (2, 80))
    points = np.stack([column, row], 1).astype(np.float32)
    (x, y), diameters, _ = cv2.fitEllipse(points)
    strays = np.array([[30.0], [40.0]]) + rng.uniform(-25, 25, (2, 40))
    rows, columns = np.concatenate([row, strays[0]]), np.concatenate([column, strays[1]])
    fitted = fit_ellipses(rows, columns, [round_guess(FIRST, 0.5)], noise_distance=0.5)
    assert fitted is not None
    (found,), u = fitted
    assert (found.row, found.column) == pytest.approx((y, x), abs=0.05)
    assert 2 * found.semi_major == pytest.approx(max(diameters), abs=0.12)
    assert 2 * found.semi_minor == pytest.approx(min(diameters), abs=0.12)
    assert np.median(u[0, 80:]) < 0.05
    assert u[0, :80].min() > 0.8


def test_shells_of_points_on_open_curves_are_none() -> None:
    t = np.linspace(-1, 1, 40)
    guess = Ellipse(0.0, 0.0, 10.0, 10.0, 0.0, 0.0)
    assert fit_ellipses(10 * np.sinh(2 * t), 10 * np.cosh(2 * t), [guess]) is None
    assert fit_ellipse(10 * np.sinh(2 * t), 10 * np.cosh(2 * t)) is None
