import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from analysis.imaging.ellipse_shells import fit_ellipse
from analysis.imaging.shells import Ellipse


def ring(ellipse: Ellipse, count: int = 80) -> np.ndarray:
    t = np.linspace(0, 2 * math.pi, count, endpoint=False)
    along, across = ellipse.semi_major * np.cos(t), ellipse.semi_minor * np.sin(t)
    c, s = math.cos(ellipse.angle), math.sin(ellipse.angle)
    return np.stack([ellipse.row + c * along - s * across, ellipse.column + s * along + c * across])


FIRST = Ellipse(30.0, 40.0, 14.0, 9.0, 0.5, 0.0)


def assert_alike(found: Ellipse, truth: Ellipse, tolerance: float) -> None:
    for name in ("row", "column", "semi_major", "semi_minor"):
        assert getattr(found, name) == pytest.approx(getattr(truth, name), abs=tolerance), name
    turned = (found.angle - truth.angle + math.pi / 2) % math.pi - math.pi / 2
    assert abs(turned) < tolerance


@settings(max_examples=40, deadline=None)
@given(major=st.floats(6, 20), flatness=st.floats(0.5, 0.95), angle=st.floats(-1.5, 1.5))
def test_points_on_an_ellipse_give_that_ellipse(
    major: float, flatness: float, angle: float
) -> None:
    truth = Ellipse(30.0, 40.0, major, flatness * major, angle, 0.0)
    found = fit_ellipse(*ring(truth))
    assert found is not None
    assert_alike(found, truth, 1e-3)


@pytest.mark.parametrize("seed", range(4))
def test_the_ellipse_of_points_with_noise_is_that_of_opencv(seed: int) -> None:
    rng = np.random.default_rng(seed)
    row, column = ring(FIRST) + rng.normal(0, 0.05, (2, 80))
    points = np.stack([column, row], 1).astype(np.float32)
    (x, y), diameters, _ = cv2.fitEllipse(points)
    found = fit_ellipse(row, column)
    assert found is not None
    assert (found.row, found.column) == pytest.approx((y, x), abs=0.05)
    assert 2 * found.semi_major == pytest.approx(max(diameters), abs=0.12)
    assert 2 * found.semi_minor == pytest.approx(min(diameters), abs=0.12)


def test_points_on_open_curves_are_no_ellipse() -> None:
    t = np.linspace(-1, 1, 40)
    assert fit_ellipse(10 * np.sinh(2 * t), 10 * np.cosh(2 * t)) is None
