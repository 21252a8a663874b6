"""Shots in the plane of figure 7.4 lie on the law that made them."""

from __future__ import annotations

import json

import numpy as np
import pytest

from analysis.model.fitting.fit import fit_campaign
from analysis.model.plane import Plane, impact_plane
from tests.unit.analysis.model.hard_spheres import campaign

LAW = (0.74, 0.08, 0.5)
SHOTS = 60


@pytest.fixture(scope="module")
def plane() -> Plane:
    data = campaign(SHOTS, 81, LAW)
    return impact_plane(data, fit_campaign(data))


def walton(x: np.ndarray) -> np.ndarray:
    """Return the two lines of the law that made the campaign; 1 + 1/K is 3.5."""
    e, mu, beta0 = LAW
    return np.maximum(-beta0 * x, x - 3.5 * mu * (1 + e))


def test_shots_scatter_about_the_law_that_made_them_as_their_errors_say(plane: Plane) -> None:
    square = float((((plane.y - walton(plane.x)) / plane.sigma) ** 2).mean())
    assert square == pytest.approx(1, abs=4 * np.sqrt(2 / SHOTS))
    assert list(plane.shots) == list(range(1, SHOTS + 1))


def test_the_lines_are_those_of_the_fit(plane: Plane) -> None:
    np.testing.assert_allclose(plane.walton, walton(plane.law_x), atol=0.02)
    assert (plane.e, plane.mu) == pytest.approx(LAW[:2], abs=0.01)
    assert plane.law_x[0] == 0
    assert plane.law_x[-1] > plane.x.max()


def test_maw_slides_with_walton_and_rebounds_less_where_it_sticks(plane: Plane) -> None:
    # Elastic spheres slide throughout beyond v_s / v_n = mu (7 - 1 / kappa); losses change little.
    sliding = plane.law_x > 0.08 * (7 - 7 / 6)
    np.testing.assert_allclose(plane.maw[sliding], plane.walton[sliding], atol=2e-3)
    low = (plane.law_x > 0.02) & (plane.law_x < 0.3)
    assert (plane.maw[low] > plane.walton[low]).all()
    assert plane.poisson_ratio == pytest.approx(0.25)


def test_the_plane_is_one_json_document(plane: Plane) -> None:
    document = json.loads(json.dumps(plane.to_json(), allow_nan=False))
    assert document["x"] == plane.x.tolist()
    assert document["mu"] == plane.mu
