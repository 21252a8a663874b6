"""A stated form is tested on shots that it has not seen."""

from __future__ import annotations

from pathlib import Path

import pytest

from analysis.effects.catalogue import CATALOGUE
from analysis.effects.own.loading import load_effects
from analysis.errors import ProposalRefusedError
from analysis.model.proposals.confirm import confirm, without_shots
from analysis.model.proposals.effect_file import written
from analysis.model.proposals.propose import propose
from analysis.model.proposals.stated import Origin, Statement
from rigctl.errors import AnalysisInputError
from rigctl.model.proposing import confirmed, confirmed_statement
from tests.unit.analysis.model.proposals.hidden import SHOTS, campaign, proposed

LAW, AMPLITUDE = "restitution-bump", 0.008


@pytest.fixture
def form(tmp_path: Path) -> Path:
    """Return the file of a proposal."""
    [path] = written(tmp_path, "first", proposed(LAW, AMPLITUDE)[1])
    return path


def test_a_true_form_is_confirmed_on_other_shots(form: Path) -> None:
    [effect] = load_effects(form, CATALOGUE).effects
    found = confirm(campaign({LAW: AMPLITUDE}, seed=99), (), effect)
    assert found.confirmed
    assert found.p_value < 1e-6
    amplitude = found.parameters["a"]
    assert abs(amplitude.value - AMPLITUDE) < 5 * amplitude.sigma


def test_shots_that_only_the_form_explains_count_in_its_test() -> None:
    _, found = proposed("friction-temperature", 0.03, 45)
    effect = found.accepted[0].form.effect("stated")
    again = confirm(campaign({"friction-temperature": 0.03}, seed=42), (), effect)
    assert again.shots == SHOTS
    assert abs(again.parameters["a"].value - 0.03) < 4 * again.parameters["a"].sigma


def test_a_form_that_is_not_there_is_not_confirmed(form: Path) -> None:
    [effect] = load_effects(form, CATALOGUE).effects
    chances = [confirm(campaign({}, seed), (), effect).p_value for seed in range(50, 54)]
    assert min(chances) > 1e-4


def test_a_form_is_tested_beside_the_effects_it_was_chosen_beside(tmp_path: Path) -> None:
    both = {LAW: AMPLITUDE, "image-scale": 0.01}
    found = propose(campaign(both, seed=4), (), CATALOGUE)
    assert found.effects == ("image-scale",)
    path = next(p for p in written(tmp_path, "first", found) if "bump" in p.name)
    again = confirmed("second", campaign(both, seed=98), (), path)
    assert again.beside == ("image-scale",)
    assert again.confirmed
    assert again.error_after < 1.02


def test_an_effect_that_nobody_knows_any_more_is_asked_for(tmp_path: Path) -> None:
    found = proposed(LAW, AMPLITUDE)[1]
    stated = Statement.of(found.accepted[0].form, Origin("first", "1-60", ("my-own",)))
    with pytest.raises(AnalysisInputError, match="chosen beside my-own"):
        confirmed_statement("second", campaign({}, 5), (), stated)


def test_shots_that_the_form_was_chosen_on_are_left_out() -> None:
    data = campaign({}, 1)
    assert list(without_shots(data, set(range(1, 41))).shots) == list(range(41, 61))
    with pytest.raises(ProposalRefusedError, match="0 shots of these"):
        without_shots(data, set(range(1, 61)))
