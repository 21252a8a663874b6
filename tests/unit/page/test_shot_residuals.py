"""One shot against the model: which numbers of a fit are its own."""

from __future__ import annotations

import json
from typing import Any

from rigctl.page.shots.residuals import pulls, residuals_of


def cell(channel: str, covariate: str, shots: list[int], residual: list[float]) -> dict[str, Any]:
    points = {"shots": shots, "residual": residual, "sigma": [0.5] * len(shots), "unit": "mm/s"}
    return {"channel": channel, "covariate": covariate, "points": json.dumps(points)}


CELLS = [
    cell("relative velocity n", "ln v_n", [3, 5], [1.0, -4.0]),
    cell("relative velocity n", "offset_mm", [3, 5], [1.0, -4.0]),
    cell("relative position n", "time", [5, 5], [9.0, 9.0]),
    cell("image X", "field X", [5], [9.0]),
    cell("common spin b", "ln v_n", [3], [2.0]),
]


def test_a_shot_has_one_residual_a_quantity_whatever_it_is_plotted_against() -> None:
    [found] = residuals_of(5, CELLS)
    assert (found.quantity, found.value, found.sigma, found.unit) == (
        "relative velocity n",
        -4.0,
        0.5,
        "mm/s",
    )
    assert found.deviations == -8.0


def test_quantities_of_one_kind_stand_together() -> None:
    names = [one.quantity for one in residuals_of(3, CELLS)]
    assert names == ["common spin b", "relative velocity n"]


def test_a_shot_that_the_fit_did_not_use_has_none() -> None:
    assert residuals_of(99, CELLS) == []


def test_what_lies_beyond_three_errors_has_another_form_and_is_in_the_picture() -> None:
    drawn = pulls(residuals_of(5, CELLS), "name")
    assert drawn["data"][0]["marker"]["symbol"] == ["triangle-up"]
    low, high = drawn["layout"]["xaxis"]["range"]
    assert low < -8.0 < high
