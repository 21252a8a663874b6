"""Step 2 of the story: a hint shows the cell that errs most where it says to look."""

from __future__ import annotations

from typing import Any

from analysis.model.verdict.standing import Standing, Word
from rigctl.page.model.story.where import Cells, Grid, cause_first


def cell(channel: str, deviation: float) -> dict[str, Any]:
    return {"channel": channel, "covariate": "time", "deviation": deviation}


def test_the_most_striking_cell_is_looked_at_first() -> None:
    first = cell("relative velocity n", 9.0)
    assert Cells([first, cell("image y", 5.0)]).chosen == first


def test_what_happens_at_the_bounce_is_named_there_and_not_in_the_flights_that_it_bends() -> None:
    flight = {"channel": "relative position n", "covariate": "time", "p_familywise": 1e-9}
    bounce = {"channel": "normal velocity", "covariate": "ln v_n", "p_familywise": 1e-9}
    flight, bounce = flight | {"deviation": 52.0}, bounce | {"deviation": 18.0}
    found: dict[str, Any] = {"findings": [flight, bounce], "own": []}
    missing = Standing(Word.MISSING, ("restitution-plastic",))
    assert cause_first(found, missing) == [bounce, flight]
    # What acts in the air is named there, and what no effect explains where it is surest.
    assert cause_first(found, Standing(Word.MISSING, ("drag",))) == [flight, bounce]
    assert cause_first(found, Standing(Word.UNEXPLAINED)) == [flight, bounce]
    found["findings"][1] = bounce | {"p_familywise": 0.3}
    assert cause_first(found, missing)[0] == flight


def test_how_it_hit_is_named_before_the_setting_that_brings_it_about_and_before_a_mean() -> None:
    def seen(covariate: str, deviation: float) -> dict[str, Any]:
        said = {"channel": "normal velocity", "covariate": covariate, "p_familywise": 1e-9}
        return {**said, "deviation": deviation}

    missing = Standing(Word.MISSING, ("restitution-plastic",))
    for other, told in (("always", 24.0), ("pressure_a_kpa", 24.0), ("order", None)):
        cells = [seen(other, 44.0), seen("contact X", 30.0), seen("ln v_n", 24.0)]
        first = cause_first({"findings": cells, "own": []}, missing)[0]
        assert first["deviation"] == (told or 44.0)
    weak = [seen("always", 44.0), seen("ln v_n", 9.0)]
    assert cause_first({"findings": weak, "own": []}, missing) == weak


def test_a_hint_shows_the_first_cell_of_its_place_and_its_map() -> None:
    many = [cell("relative velocity n", 20.0 - k) for k in range(6)]
    image, other = cell("image y", 3.0), cell("image x", 2.0)
    where = Cells([*many, image, other])
    assert where.look_at("in the camera")
    assert where.chosen == image
    assert where.here == [image, other]
    assert where.look_at("at the bounce")
    assert where.chosen == many[0]


def test_a_place_without_cells_leaves_what_is_drawn() -> None:
    first = cell("relative velocity n", 9.0)
    where = Cells([first])
    assert not where.look_at("in the air")
    assert where.chosen == first


def test_nothing_is_looked_at_before_there_is_an_answer() -> None:
    assert Cells([]).chosen is None


def test_the_map_puts_physics_before_settings_and_keeps_the_column_of_an_unknown_name() -> None:
    cells = [
        {"channel": "normal velocity", "covariate": name}
        for name in ("pressure_a_kpa", "ln v_n", "humidity", "always", "contact X")
    ]
    assert Grid.of(cells).groups == [
        ("", ["always"]),
        ("How it hit", ["ln v_n"]),
        ("Where", ["contact X"]),
        ("Set-up", ["humidity", "pressure_a_kpa"]),
    ]
