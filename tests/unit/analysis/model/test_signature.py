"""An effect's own cells: where it shows, and where one that stands for another leaves marks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.structure.lackoffit import Cell, holm, lack_of_fit
from tests.unit.analysis.model.chosen import chosen
from tests.unit.analysis.model.hard_spheres import Hidden, campaign

pytestmark = pytest.mark.long

ALARM = 0.01
[SCALE] = chosen("image-scale")


def stretched(data: PoseData, share: float) -> PoseData:
    return replace(data, position=data.position * (1 + share))


def with_scale(data: PoseData) -> Fit:
    fit = fit_campaign(data)
    return fit_campaign(data, fit.theory.with_effect(SCALE), fit)


def own(cells: tuple[Cell, ...]) -> set[tuple[str, str]]:
    return {(cell.channel, cell.covariate) for cell in cells if cell.own_of == ("image-scale",)}


def test_stretched_pictures_show_in_each_coordinate_along_itself_and_in_the_distance() -> None:
    data = stretched(campaign(30, 800), 1e-3)
    found = own(lack_of_fit(data, with_scale(data)))
    assert {("image Y", "field Y"), ("relative position n", "time")} < found
    assert len(found) == 4


def test_an_effect_that_is_there_leaves_nothing_in_its_own_cells() -> None:
    alarms = 0
    for seed in range(4):
        data = stretched(campaign(30, 820 + seed), 1e-3)
        alarms += any(cell.p_holm < ALARM for cell in lack_of_fit(data, with_scale(data)))
    # Each alarms with a chance of 0.02: two or more of four in 0.3 per cent of all cases.
    assert alarms <= 1


def test_an_effect_that_stands_for_another_is_betrayed_where_all_cells_together_are_silent() -> (
    None
):
    data = campaign(40, 841, hidden=Hidden(pull=6.6))
    cells = lack_of_fit(data, with_scale(data))
    plain = holm(np.array([cell.p_value for cell in cells]))
    assert plain.min() > ALARM
    betrayed = [c for c in cells if c.p_holm < ALARM]
    assert ("relative position n", "time") in {(c.channel, c.covariate) for c in betrayed}


def test_without_an_effect_no_cell_is_looked_at_by_itself() -> None:
    data = campaign(20, 850)
    cells = lack_of_fit(data, fit_campaign(data))
    assert all(cell.own_of == () for cell in cells)
    assert cells[0].p_holm == min(1.0, len(cells) * cells[0].p_value)
