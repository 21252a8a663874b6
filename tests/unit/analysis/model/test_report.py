"""The verdict's document is plain JSON with the keys that other programs rely on."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from analysis.model.verdict.documents import verdict_document
from analysis.model.verdict.selection import explain
from analysis.model.verdict.words import doubts, verdict_sentence
from analysis.schema.codec import read, written
from analysis.schema.verdict import VerdictReport
from tests.unit.analysis.model.chosen import WIDELY_BELIEVED
from tests.unit.analysis.model.hard_spheres import Hidden, campaign

KEYS = {
    *("campaign", "shots", "used", "excluded", "rejected", "rejected_frames", "verdict", "effects"),
    *("alias_set", "alias_sets", "unexplained", "chi2_per_dof", "path", "parameters", "candidates"),
    *("noise", "structure", "next_shots", "torn_tracks", "alarms", "p_chi2"),
    "nuisances",
    "formulas",
}
CANDIDATE = {
    *("effect", "score", "p_value", "p_familywise", "promised_fall"),
    *("amplitude", "sigma", "unit", "plausible", "plausible_range", "of_measurement", "moved_m"),
}
CELL = {
    *("channel", "covariate", "chi2", "degrees_of_freedom", "p_value", "p_familywise"),
    "of_measurement",
}


def document(data: Any) -> dict[str, Any]:
    made = verdict_document("nylon", data, explain(data, WIDELY_BELIEVED))
    # Out and in again: what is not JSON, or is not a number, cannot pass.
    plain: dict[str, Any] = json.loads(json.dumps(made, allow_nan=False))
    return plain


@pytest.fixture(scope="module")
def documents() -> dict[str, dict[str, Any]]:
    scaled = campaign(30, 81)
    spoilt = scaled.position * 1.003
    spoilt[4, :, 0, 1] += 4e-4 * np.sin(np.arange(24) / 2)
    spoilt[9, 2, 1, 1] += 2e-3
    slow = campaign(30, 82)
    return {
        "none": document(campaign(30, 80)),
        "effect": document(replace(scaled, position=spoilt)),
        "alias": document(replace(slow, times_s=slow.times_s / 1.01)),
        "unexplained": document(campaign(30, 83, hidden=Hidden(pull=60.0))),
    }


@pytest.mark.parametrize("word", ["none", "effect", "alias", "unexplained"])
def test_every_verdict_has_the_keys_of_the_contract(
    documents: dict[str, dict[str, Any]], word: str
) -> None:
    found = documents[word]
    assert set(found) == KEYS
    assert found["verdict"] == word
    assert found["unexplained"] is (word == "unexplained")
    assert {*map(frozenset, found["candidates"])} == {frozenset(CANDIDATE)}
    assert {*map(frozenset, found["structure"])} <= {frozenset(CELL)}
    assert all(set(s) == {"with", "chi2_per_dof", "prediction_error"} for s in found["path"])
    assert {"e", "mu", "beta0"} <= set(found["parameters"])
    assert all(set(q) == {"value", "sigma", "unit"} for q in found["parameters"].values())
    assert found["path"][-1]["chi2_per_dof"] == found["chi2_per_dof"]
    assert all(0 < c["p_value"] <= 1 for c in found["candidates"])


@pytest.mark.parametrize("word", ["none", "effect", "alias", "unexplained"])
def test_a_verdict_that_is_read_and_written_again_is_the_same_document(
    documents: dict[str, dict[str, Any]], word: str
) -> None:
    again = written(read(VerdictReport, documents[word]))
    assert json.loads(json.dumps(again)) == documents[word]


def test_a_verdict_that_is_none_is_refused_by_field(documents: dict[str, dict[str, Any]]) -> None:
    with pytest.raises(ValidationError, match="p_chi2"):
        read(VerdictReport, {**documents["none"], "p_chi2": 1.5})
    with pytest.raises(ValidationError, match="verdict"):
        read(VerdictReport, {**documents["none"], "verdict": "perhaps"})


def test_what_was_taken_out_is_listed_by_the_numbers_of_the_shots(
    documents: dict[str, dict[str, Any]],
) -> None:
    found = documents["effect"]
    assert found["rejected"] == [5]
    assert found["rejected_frames"] == [[10, 2]]
    assert (found["shots"], found["used"]) == (30, 29)


def test_only_what_alarms_is_structure(documents: dict[str, dict[str, Any]]) -> None:
    assert documents["none"]["structure"] == []
    assert documents["effect"]["structure"] == []
    left = documents["unexplained"]["structure"]
    assert all(cell["p_familywise"] < 0.01 for cell in left)


def test_a_chance_by_itself_is_never_more_than_that_with_all_cells_looked_at(
    documents: dict[str, dict[str, Any]],
) -> None:
    left = documents["unexplained"]["structure"]
    assert left
    for one in (*left, *documents["effect"]["candidates"]):
        assert 0 < one["p_value"] <= one["p_familywise"] <= 1
    # The most striking of many is less rare than it is by itself.
    shown = [cell for cell in left if cell["p_familywise"] < 1 and cell["p_value"] > 1e-300]
    assert all(cell["p_value"] < cell["p_familywise"] for cell in shown)


def test_the_candidates_stand_in_the_order_of_what_they_promise(
    documents: dict[str, dict[str, Any]],
) -> None:
    falls = [c["promised_fall"] for c in documents["effect"]["candidates"]]
    assert falls == sorted(falls, reverse=True)
    assert documents["effect"]["candidates"][0]["effect"] == "image-scale"


def test_a_sentence_says_the_verdict(documents: dict[str, dict[str, Any]]) -> None:
    said = {word: verdict_sentence(read(VerdictReport, found)) for word, found in documents.items()}
    assert said["none"] == "nylon: nothing is missing, as far as 30 shots can tell."
    assert "the missing effect is image-scale; with it the error" in said["effect"]
    assert "frame-rate" in said["alias"]
    assert " or " in said["alias"]
    assert "these shots cannot tell" in said["alias"]
    assert "something is missing that the catalogue does not hold." in said["unexplained"]
    assert f"most in {documents['unexplained']['structure'][0]['channel']}" in said["unexplained"]


def test_more_left_than_noise_is_never_said_to_be_nothing(
    documents: dict[str, dict[str, Any]],
) -> None:
    said = verdict_sentence(
        read(VerdictReport, {**documents["none"], "chi2_per_dof": 1.247, "p_chi2": 0.053})
    )
    assert "nothing is missing" not in said
    assert "no effect that 30 shots tell is missing, but chi-squared is 1.25" in said
    assert "with a chance of 0.053" in said


def test_an_effect_that_is_sure_is_said_beside_those_that_are_not(
    documents: dict[str, dict[str, Any]],
) -> None:
    found = documents["alias"]
    sets = {"drag": ["drag"], **found["alias_sets"]}
    said = verdict_sentence(
        read(VerdictReport, {**found, "effects": list(sets), "alias_sets": sets})
    )
    assert said.startswith("nylon: drag is missing, and one of ")


def test_two_effects_that_both_have_company_are_said_each_with_its_own(
    documents: dict[str, dict[str, Any]],
) -> None:
    sets = {"drag": ["drag", "wind"], "frame-rate": ["frame-rate", "gravity-value"]}
    said = verdict_sentence(
        read(VerdictReport, {**documents["alias"], "effects": list(sets), "alias_sets": sets})
    )
    whole = "the missing effects are one of drag or wind and one of frame-rate or gravity-value"
    assert whole in said


def test_a_candidate_of_a_size_that_is_not_believed_is_said_and_not_hidden(
    documents: dict[str, dict[str, Any]],
) -> None:
    found = documents["effect"]
    best = found["candidates"][0]
    other = {
        **{**best, "effect": "gravity-value", "promised_fall": 0.9 * best["promised_fall"]},
        **{"amplitude": 0.31, "sigma": 0.02, "unit": "m/s^2"},
        **{"plausible": False, "plausible_range": [-0.03, 0.03]},
    }
    faint = {**other, "effect": "drag", "promised_fall": 0.1 * best["promised_fall"]}
    assert doubts(read(VerdictReport, {**found, "candidates": [best, other, faint]})) == [
        "gravity-value by itself would promise as much, but with 0.310(20) m/s^2, where -0.03 to "
        "0.03 m/s^2 is believed."
    ]
    assert doubts(read(VerdictReport, {**found, "candidates": [best]})) == []


def test_two_effects_are_said_in_the_plural(documents: dict[str, dict[str, Any]]) -> None:
    found = {**documents["effect"], "effects": ["image-scale", "drag"]}
    said = verdict_sentence(read(VerdictReport, found))
    assert "the missing effects are image-scale and drag; with them the error" in said
