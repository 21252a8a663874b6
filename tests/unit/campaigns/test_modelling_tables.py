"""Campaigns that came as tables alone: jobs answer as the commands do of their folders."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from analysis.effects.catalogue import CATALOGUE
from analysis.model.data.gather import gather
from analysis.model.fitting.robust_fit import robust_fit
from analysis.model.rank.ranking import rank
from rigctl.errors import AnalysisInputError
from rigctl.exchange.contents import read_contents
from rigctl.exchange.importing import import_campaign
from rigctl.measuring.measured import measured_files, request
from rigctl.model.computing import (
    agreement_job,
    explain_job,
    fit_job,
    next_job,
    picture_job,
    ranking_job,
    structure_job,
)
from rigctl.store import Store
from tests.unit.analysis.model.tabulated import PLATE, contacts, impacts

Json = dict[str, Any]


def silent(_text: str, _share: float | None) -> None:
    """Say nothing."""


def question(store: Store, folder: Path, effects: tuple[str, ...] = ()) -> Json:
    """Import a folder and return what jobs are asked of it."""
    import_campaign(store, read_contents(folder, silent), "anna", name="tables", progress=silent)
    return request("tables", measured_files(store, "tables"), effects, store)


@pytest.mark.parametrize(
    "write",
    [
        lambda place: contacts(place, 20, 62),
        lambda place: impacts(place, 20, 61, description=PLATE),
    ],
)
def test_a_fit_and_a_ranking_are_those_of_the_folder(
    store: Store, tmp_path: Path, write: Callable[[Path], Path]
) -> None:
    folder = write(tmp_path / "tables")
    document = ranking_job(question(store, folder), silent)
    wanted = robust_fit(gather(folder)[1])
    assert document["shots"] == 20
    values = {name: one["value"] for name, one in document["parameters"].items()}
    assert values == {name: one.value for name, one in wanted.fit.parameters().items()}
    ranked = rank(wanted.data, wanted.fit, CATALOGUE).candidates
    assert [one["effect"] for one in document["candidates"]] == [c.effect.name for c in ranked]


def test_a_shot_that_was_excluded_since_is_left_out_and_named(store: Store, tmp_path: Path) -> None:
    folder = contacts(tmp_path / "tables", 20, 62)
    question(store, folder)
    store.exclude("i0001-000003", "the tube was dirty", "anna")
    asked = request("tables", measured_files(store, "tables"), (), store)
    document = fit_job(asked, silent)
    assert (document["shots"], document["excluded"]) == (19, [3])


def test_every_question_about_a_table_has_an_answer(store: Store, tmp_path: Path) -> None:
    asked = question(store, contacts(tmp_path / "tables", 20, 62))
    stages = agreement_job(asked, silent)["stages"]
    assert [stage["stage"] for stage in stages] == ["after contact"]
    assert structure_job(asked, silent)["structure"]["cells"]
    assert explain_job(asked, silent)["verdict"] == "none"
    assert picture_job(asked, silent)["launch_left_out"]


def test_an_effect_that_a_table_cannot_show_is_not_fitted(store: Store, tmp_path: Path) -> None:
    asked = question(store, contacts(tmp_path / "tables", 20, 62), ("drag",))
    with pytest.raises(AnalysisInputError, match=r"with: .*tabulated contacts \(found 'drag'\)"):
        fit_job(asked, silent)


def test_a_table_foretells_no_shot(store: Store, tmp_path: Path) -> None:
    asked = question(store, contacts(tmp_path / "tables", 20, 62))
    more = {"between": None, "sharpen": "e", "to": None, "probability": 0.9}
    limits = {"limits": [[5.0, 80.0], [0.0, 22.0]]}
    with pytest.raises(AnalysisInputError, match=r"tables: tabulated contacts .* give its poses"):
        next_job(asked | more | limits, silent)
