"""The points that are shown for an effect, and the line that its best size draws among them."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from rigctl.page.model.story.preview import gained, plainest

NOISE = np.random.default_rng(5)
Cell = tuple[dict[str, Any], dict[str, Any]]


def cell(
    channel: str, covariate: str, law: Callable[[Any], Any], noise: float, frame: int = -1
) -> Cell:
    """Return a cell before and after a fit that takes the law away and leaves the noise."""
    x = np.sort(NOISE.uniform(-1.0, 1.0, 40))
    rest = noise * NOISE.standard_normal(40)

    def of(residual: Any) -> dict[str, Any]:
        mean = float(np.mean(residual))
        points = {
            "shots": list(range(1, 41)),
            "frames": [frame] * 40,
            "x_label": covariate,
            "x": x.tolist(),
            "residual": residual.tolist(),
            "trend": {"x": [-1.0, 1.0], "mean": [mean, mean]},
        }
        named = {"channel": channel, "covariate": covariate, "p_familywise": 1e-9}
        return {**named, "points": json.dumps(points)}

    return of(law(x) + rest), of(rest)


def shown(cells: list[Cell], place: str) -> tuple[str, str]:
    """Return the names of the cell that is shown."""
    before, after = ({"findings": [pair[k] for pair in cells]} for k in (0, 1))
    found = plainest(before, after, place)
    assert found is not None
    return found[0]["channel"], found[0]["covariate"]


def test_an_effect_of_the_contact_is_shown_by_what_the_contact_did() -> None:
    in_picture = cell("image X", "field Y", lambda x: 5 * x, 0.01)
    gap = cell("relative position t", "time", lambda x: 5 * x, 0.01)
    spin = cell("common spin b", "ln v_s/v_n", lambda x: x, 0.3)
    idle = cell("relative velocity n", "ln v_n", lambda x: 0 * x, 0.3)
    cells = [in_picture, gap, idle, spin]
    assert shown(cells, "contact") == ("common spin b", "ln v_s/v_n")
    # Where the contact shows nothing of it, and where an effect has no place, the plainest is.
    assert shown([in_picture, idle], "contact") == ("image X", "field Y")
    assert shown([spin, gap], "")[0] == "relative position t"


def test_of_cells_that_show_an_effect_alike_the_physical_one_goes_before_the_setting() -> None:
    offset = cell("relative velocity n", "offset_mm", lambda x: x, 0.05)
    speed = cell("relative velocity n", "ln v_n", lambda x: x, 0.1)
    assert shown([offset, speed], "contact") == ("relative velocity n", "ln v_n")


def test_where_few_shots_tell_no_difference_the_physical_one_goes_before_the_place() -> None:
    # Of 40 shots a share of a fourth is known to a tenth: 0.27 and 0.22 are alike.
    place = cell("common spin b", "contact Y", lambda x: x, 0.95)
    hit = cell("relative velocity t", "ln v_s/v_n", lambda x: x, 1.05)
    assert shown([place, hit], "contact") == ("relative velocity t", "ln v_s/v_n")


@pytest.mark.parametrize("place", [-1.0, -0.3, 0.0, 0.4, 1.0])
def test_the_line_of_the_best_size_lies_on_the_dots_at_a_peak_and_at_the_ends(place: float) -> None:
    def law(x: Any) -> Any:
        return 10 * np.exp(-((x / 0.3) ** 2)) + 4 * x**3

    before, after = (json.loads(one["points"]) for one in cell("", "ln v_n", law, 3.0))
    line = gained(before, after, np.array([place]))
    # The noise of the shots is a third of the peak, and has no part in it.
    assert line[0] == pytest.approx(law(np.array(place)), abs=1.3)


def test_an_effect_that_no_cell_shows_by_itself_is_drawn_where_its_curve_is_largest() -> None:
    rolling = cell("relative orientation b", "time", lambda x: 0.001 * x, 1.0)
    path = cell("relative position b", "time", lambda x: 0.2 * x, 1.0)
    spin = cell("common spin b", "ln v_n", lambda x: 0.05 * x, 1.0)
    for cells in ([rolling, path, spin], [spin, rolling, path]):
        assert shown(cells, "flight") == ("relative position b", "time")


def test_of_many_weak_cells_each_row_is_looked_at() -> None:
    idle = [cell("common velocity n", f"column {k}", lambda x: 0 * x, 1.0) for k in range(20)]
    faint = cell("common spin b", "order", lambda x: 0.01 * x, 1.0)
    plain = cell("common spin b", "ln v_n", lambda x: 0.2 * x, 1.0)
    assert shown([*idle, faint, plain], "contact") == ("common spin b", "ln v_n")
