import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import bisect

from analysis.collision.instant import touching_time

D = np.array(0.0254)
coordinate = st.floats(-0.05, 0.05)
speed = st.floats(-3.0, 3.0)
vectors = st.tuples(coordinate, coordinate, coordinate).map(np.array)
velocities = st.tuples(speed, speed, speed).map(np.array)


def gap(separation: np.ndarray, velocity: np.ndarray, time: float) -> float:
    return float(np.linalg.norm(separation + velocity * time) - D)


@given(separation=vectors, velocity=velocities)
def test_the_touch_is_where_bisection_finds_the_gap_closed(
    separation: np.ndarray, velocity: np.ndarray
) -> None:
    square = float(velocity @ velocity)
    assume(square > 0.01)
    nearest = -float(separation @ velocity) / square
    closest = gap(separation, velocity, nearest)
    assume(abs(closest) > 1e-6)
    found = touching_time(separation, velocity, D)
    if closest > 0:
        assert np.isnan(found)
        return
    long_before = nearest - 2 * D / math.sqrt(square)
    expected = bisect(lambda t: gap(separation, velocity, t), long_before, nearest, xtol=1e-15)
    assert found == pytest.approx(expected, abs=1e-9)


def test_spheres_that_pass_each_other_by_do_not_touch() -> None:
    past = np.array([1.001 * D, -0.05, 0.0])
    assert np.isnan(touching_time(past, np.array([0.0, 2.0, 0.0]), D))
    grazing = np.array([0.999 * D, -0.05, 0.0])
    assert np.isfinite(touching_time(grazing, np.array([0.0, 2.0, 0.0]), D))


def test_spheres_that_keep_their_distance_do_not_touch() -> None:
    assert np.isnan(touching_time(np.array([0.0, 0.05, 0.0]), np.zeros(3), D))


def test_the_constant_of_equation_5_36_holds_the_diameter() -> None:
    # Centres 2 D apart close at 2 m/s: they touch after D / 2 s. Without D^2 in the constant the
    # root is where the centres would coincide, after 2 D / 2 s.
    found = touching_time(np.array([0.0, 2 * D, 0.0]), np.array([0.0, -2.0, 0.0]), D)
    assert found == pytest.approx(D / 2)
    assert found != pytest.approx(D, rel=0.1)


def test_a_touch_in_the_past_has_a_negative_time() -> None:
    # Overlapping by half a diameter while closing at 1 m/s.
    found = touching_time(np.array([0.0, D / 2, 0.0]), np.array([0.0, -1.0, 0.0]), D)
    assert found == pytest.approx(-D / 2)
