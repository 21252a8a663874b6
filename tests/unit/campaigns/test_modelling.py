"""What jobs compute, against the same computed from the exchange folder."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from analysis.effects.catalogue import CATALOGUE
from analysis.model.data.gather import gather
from analysis.model.fitting.robust_fit import robust_fit
from rigctl.errors import NotFoundError
from rigctl.measuring.measured import measured_files, request
from rigctl.model.computing import fit_job, ranking_job
from rigctl.model.known_effects import effect_named
from rigctl.store import Store

Keep = Callable[..., list[str]]


def test_a_fit_of_stored_shots_is_that_of_their_folder(
    store: Store, keep: Keep, folder: Path
) -> None:
    keep()
    said: list[str] = []
    document = fit_job(
        request("nylon", measured_files(store, "nylon"), ["drag"]),
        lambda text, share: said.append(text),
    )
    drag = next(effect for effect in CATALOGUE if effect.name == "drag")
    wanted = robust_fit(gather(folder)[1], [drag]).fit
    assert (document["campaign"], document["shots"], document["with"]) == ("nylon", 4, ["drag"])
    assert document["chi2_per_dof"] == pytest.approx(wanted.chi2_per_dof, rel=1e-9)
    values = {name: q["value"] for name, q in document["parameters"].items()}
    assert values == pytest.approx({n: q.value for n, q in wanted.parameters().items()}, rel=1e-6)
    assert said == ["reading the poses", "fitting the base model, drag"]


def test_a_ranking_names_every_effect_that_is_not_in_the_fit(store: Store, keep: Keep) -> None:
    keep()
    asked = request("nylon", measured_files(store, "nylon"), ["drag"])
    document = ranking_job(asked, lambda text, share: None)
    ranked = [candidate["effect"] for candidate in document["candidates"]]
    names = {effect.name for effect in CATALOGUE} - {"drag"}
    assert sorted(ranked) == sorted(names)
    falls = [one["promised_fall"] for one in document["candidates"] if one["seen"]]
    assert falls == sorted(falls, reverse=True)


def test_an_effect_that_is_not_there_is_answered_with_those_that_are() -> None:
    with pytest.raises(NotFoundError) as found:
        effect_named("phlogiston")
    assert found.value.value == "'phlogiston'"
    assert all(effect.name in str(found.value.todo) for effect in CATALOGUE)
