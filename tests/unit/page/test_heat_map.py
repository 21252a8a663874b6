"""The page's heat map has the rows, columns and words of the figure."""

from __future__ import annotations

from typing import Any

from rigctl.page.parts.plots import heat_map


def cell(channel: str, covariate: str, chance: float = 0.5) -> dict[str, Any]:
    found = {"channel": channel, "covariate": covariate, "deviation": 2.0}
    return {**found, "p_familywise": chance}


def test_rows_go_from_velocities_to_orientations_and_along_n_t_b_whatever_came_first() -> None:
    names = ["common spin b", "relative position t", "relative velocity b", "relative velocity n"]
    drawn = heat_map([cell(name, "order") for name in names], None, "nylon")["layout"]
    assert drawn["yaxis"]["ticktext"] == [
        *("relative velocity n", "relative velocity b"),
        *("common spin b", "relative position t"),
    ]


def test_the_mean_stands_first_and_columns_of_the_list_have_their_units() -> None:
    names = ["pressure_a_kpa", "spin along v_t x n", "always", "ln v_n"]
    drawn = heat_map([cell("relative spin n", name) for name in names], None, "nylon")["layout"]
    assert drawn["xaxis"]["ticktext"] == [
        *("always", "ln v_n", "spin along v_t × n", "pressure a, kPa"),
    ]


def test_a_cell_that_chance_hardly_makes_is_framed_in_its_place() -> None:
    cells = [cell("relative spin n", "order"), cell("relative spin t", "order", chance=1e-4)]
    (frame,) = heat_map(cells, None, "nylon")["layout"]["shapes"]
    assert (round(frame["x0"] + 0.47), round(frame["y0"] + 0.47)) == (0, 1)
