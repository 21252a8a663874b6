"""Fuzzy c-shells beside the C code of the R package e1071 1.7-16, function cshell.

Its numbers below were printed for the points of `two_rings`; it has no noise cluster and no
ellipses.
"""

import math

import numpy as np
import pytest

from analysis.imaging.shells import Circle, fit_circles, share_out

UNKNOWN = np.zeros((3, 3))
GUESSES = [(41.0, 39.5, 19.5), (51.0, 73.0, 14.5)]
CENTRES = [(40.063913, 39.987809), (51.957112, 71.987505)]
RADII = [19.9988, 14.234038]
OBJECTIVE = 3.400281
OF_THE_FIRST_GUESS = [
    *(0.999397351948979, 0.62168434096956, 0.9949023167774879, 0.9992996145300493),
    *(0.9999062451559755, 0.0016005865536236905, 0.0010606921575799693, 0.005282451457579437),
    *(0.019195266496782812, 0.028897203129276707),
]
"""Memberships of every twelfth point in the first of the guessed circles."""


def two_rings() -> np.ndarray:
    t = np.linspace(0, 2 * math.pi, 60, endpoint=False)
    rings = [(40.0, 40.0, 20.0), (52.0, 72.0, 14.2)]
    points = np.concatenate(
        [np.stack([r + size * np.cos(t), c + size * np.sin(t)], 1) for r, c, size in rings]
    )
    return points + np.random.default_rng(11).normal(0, 0.2, points.shape)


def squares(points: np.ndarray, circles: list[tuple[float, float, float]]) -> np.ndarray:
    return np.stack(
        [(np.hypot(points[:, 0] - r, points[:, 1] - c) - size) ** 2 for r, c, size in circles]
    )


def test_memberships_are_those_of_e1071() -> None:
    points = two_rings()
    u = np.empty((len(GUESSES), len(points)))
    share_out.py_func(points[:, 0], points[:, 1], np.array(GUESSES), math.inf, u)
    np.testing.assert_allclose(u[0, ::12], OF_THE_FIRST_GUESS, rtol=1e-9)


def test_two_circles_are_those_of_e1071_and_their_objective_is_not_above() -> None:
    points = two_rings()
    start = [Circle(*guess, UNKNOWN) for guess in GUESSES]
    found, u = fit_circles(points[:, 0], points[:, 1], start, iterations=300, tolerance_px=1e-9)
    for circle, centre, radius in zip(found, CENTRES, RADII, strict=True):
        # It stops where the memberships change by less than 0.002 on average.
        assert (circle.row, circle.column) == pytest.approx(centre, abs=2e-3)
        assert circle.radius == pytest.approx(radius, abs=2e-3)
    own = squares(points, [(c.row, c.column, c.radius) for c in found])
    assert (u**2 * own).sum() <= OBJECTIVE
