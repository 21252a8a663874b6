"""Of the many points of a cell those that are drawn stand for all spheres and frames."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analysis.model.agreement.document import MOST_POINTS, drawn
from analysis.model.structure.structure import CellResiduals, Trend
from rigctl.page.model.where import undetermined


@pytest.mark.parametrize("spheres", [2, 3, 4, 8])
def test_every_sphere_is_drawn_by_its_share_however_many_take_turns(spheres: int) -> None:
    count = 4 * MOST_POINTS
    points = drawn(cell(count, spheres))
    seen = np.bincount([round(value) for value in points["residual"]], minlength=spheres)
    expected = MOST_POINTS / spheres
    assert np.all(np.abs(seen - expected) < 5 * np.sqrt(expected))


def test_points_keep_their_shots_and_their_order() -> None:
    points = drawn(cell(4 * MOST_POINTS, 2))
    assert len(points["x"]) == MOST_POINTS
    assert points["of"] == 4 * MOST_POINTS
    assert points["shots"] == sorted(points["shots"])
    assert [float(shot) for shot in points["shots"]] == points["x"]


def test_few_points_are_all_drawn() -> None:
    assert drawn(cell(50, 2))["shots"] == list(range(50))


def test_points_along_a_direction_that_nothing_measured_are_counted_and_not_drawn() -> None:
    sigma = np.where(np.arange(50) % 10 == 3, 1e3, 1.0)
    points = drawn(replace(cell(50, 2), residual=sigma, sigma=sigma))
    assert max(points["residual"]) == 1.0
    assert (points["of"], points["undetermined"]) == (45, 5)
    assert undetermined(points).startswith("5 points not drawn: nothing was measured along")
    assert undetermined(drawn(cell(50, 2))) == ""


def test_numbers_have_the_digits_that_a_picture_shows() -> None:
    values = np.array([0.0, -1234567.0, 0.000123456789, 9.99999, -0.1, 1e-300, 2.5])
    many = replace(cell(len(values), 2), residual=values)
    assert drawn(many)["residual"] == [float(f"{value:.5g}") for value in values]


def cell(count: int, spheres: int) -> CellResiduals:
    """Return a cell of spheres that take turns; each one's residual is its number."""
    number = np.arange(count)
    trend = Trend(np.zeros(1), np.zeros(1), np.ones(1))
    return CellResiduals(
        channel="position a",
        covariate="time",
        unit="mm",
        shots=number,
        frames=number,
        place=number.astype(float),
        residual=(number % spheres).astype(float),
        sigma=np.ones(count),
        trend=trend,
    )
