import math

import numpy as np
import pytest

from analysis.motion.drift import (
    WORST_LENGTH,
    Drift,
    centre_drift,
    correlation_time,
    line_variances,
    turn_drift,
)


def test_a_slow_error_forgets_itself_exponentially() -> None:
    covariance = Drift(2.0, 3e-3).covariance(np.array([0.0, 3e-3, 6e-3]))
    assert np.diag(covariance) == pytest.approx(4.0)
    assert covariance[0, 1] == pytest.approx(4.0 / math.e)
    assert covariance[0, 2] == pytest.approx(4.0 / math.e**2)
    np.testing.assert_array_equal(covariance, covariance.T)
    assert np.linalg.eigvalsh(covariance).min() > 0.0


def test_a_slow_error_grows_with_the_square_of_the_filter_and_falls_with_the_scale() -> None:
    one, wide = centre_drift(1.2, 1574.8, 1.0), centre_drift(2.4, 1574.8, 1.0)
    assert wide.sigma == pytest.approx(4 * one.sigma)
    assert one.sigma * 1574.8 == pytest.approx(0.05, abs=0.001)
    assert turn_drift(1.2, 20.0, 1.0).sigma == pytest.approx(2 * turn_drift(1.2, 40.0, 1.0).sigma)


@pytest.mark.parametrize(
    ("angle", "spin", "expected"),
    [(0.16, 32.0, 0.01), (0.16, 0.0, 1.0), (0.16, 1e5, 1e-3), (0.0, 10.0, 0.005)],
)
def test_a_marker_is_remembered_until_others_stand_in_its_place(
    angle: float, spin: float, expected: float
) -> None:
    assert correlation_time(angle, spin) == pytest.approx(expected)


@pytest.mark.parametrize("length", [0.1, 1.0, 3.4, 12.0, 50.0])
def test_a_line_through_a_slow_error_is_as_wrong_as_least_squares_make_it(length: float) -> None:
    tau = np.linspace(-0.5, 0.5, 801)
    drawn = np.linalg.pinv(np.stack([np.ones_like(tau), tau], axis=1))
    expected = drawn @ Drift(1.0, 1.0 / length).covariance(tau) @ drawn.T
    middle, slope = line_variances(np.array(length))
    assert [middle, slope] == pytest.approx(list(np.diag(expected)), rel=0.01)
    assert slope <= line_variances(np.array(WORST_LENGTH))[1] * (1 + 1e-6)
