"""Splines through equidistant values, and nodes near a radius."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from analysis.photometric.render.shading import blurred_profiles, pairs_near, refined


@pytest.mark.parametrize("knots", [5, 6, 40])
def test_the_spline_is_the_one_whose_third_derivative_goes_on_at_the_ends(knots: int) -> None:
    x = np.linspace(0.0, 1.3, knots)
    values = np.stack([np.exp(-((4 * x - 2) ** 2)), np.sin(3 * x), x**3], axis=1)
    fine = refined(values, x[1], 401, 300)
    expected = CubicSpline(x, values, axis=0)(np.arange(401) / 300)
    np.testing.assert_allclose(fine, expected, atol=1e-12)


def test_all_nodes_nearer_than_the_reach_are_paired() -> None:
    rho, t = np.linspace(0.0, 1.2, 31), np.sort(np.random.default_rng(1).uniform(0, 1, 50))
    ends, argument = pairs_near(rho, rho / 0.05**2, t, 0.05, 6.0)
    near = np.abs(rho[:, None] - t) < 0.3
    marked = (np.arange(50) >= ends[:, :1]) & (np.arange(50) < ends[:, 1:])
    np.testing.assert_array_equal(marked, near)
    np.testing.assert_allclose(argument, (rho[:, None] * t)[near] / 0.05**2)


def test_profiles_have_the_same_bits_wherever_their_arrays_lie() -> None:
    # Where an array behind the written one was taken for a part of it, once in eighty calls, its
    # loop ran otherwise and rounded otherwise.
    chance = np.random.default_rng(2)
    found = set()
    for _ in range(800):
        sizes = chance.integers(1, 200_000, chance.integers(0, 30))
        elsewhere = [np.empty(size, dtype=np.uint8) for size in sizes]
        found.add(blurred_profiles.__wrapped__(0.0434567).values.tobytes())
        del elsewhere
    assert len(found) == 1
