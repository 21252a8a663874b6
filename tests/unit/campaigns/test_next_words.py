"""Next shots asked of a campaign that no effect in question fits, and the words of the answers."""

from __future__ import annotations

from functools import cache

import pytest

from analysis.launch.prediction import Limits
from analysis.model.data.poses import PoseData
from rigctl.documents import Json
from rigctl.errors import AnalysisInputError
from rigctl.model.known_effects import available
from rigctl.model.next_shots import Known, Question, answer
from rigctl.model.next_words import sentence
from simulators.challenge.force_choice import Forces
from simulators.challenge.nature import Nature
from tests.unit.analysis.model.design.at_settings import drawn_settings, fired

LIMITS = Limits((12.0, 95.0), (0.0, 22.0))


@cache
def lasting() -> PoseData:
    return fired(drawn_settings(8, 5), Nature(forces=Forces()), 5)


def asked(question: Question) -> Json:
    known = available(None)
    return {
        "campaign": "soft",
        **answer(lasting(), question, Known(known.effects, known.named), LIMITS),
    }


@pytest.mark.parametrize("other", ["none", "wind"])
def test_of_two_effects_that_both_fail_the_answer_is_what_to_add_first(other: str) -> None:
    with pytest.raises(AnalysisInputError) as refused:
        asked(Question(between=("torsional-friction", other)))
    assert "with lasting-contact" in str(refused.value)
    assert "chi-squared is" in str(refused.value)


def test_a_parameter_of_a_law_that_fails_is_said_to_be_off() -> None:
    document = asked(Question(sharpen="mu"))
    assert not document["fits"]
    assert document["add_first"] == "lasting-contact"
    assert document["p_chi2"] < 1e-4
    assert sentence(document).endswith("First add lasting-contact.")


def test_a_parameter_of_a_law_that_fits_has_no_such_warning() -> None:
    question = Question(sharpen="mu", names=("lasting-contact",))
    document = asked(question)
    assert document["fits"]
    assert document["add_first"] is None
    assert "does not fit" not in sentence(document)


TOLD: Json = {
    "campaign": "soft",
    "between": ["drag", "wind"],
    "probability": 0.987,
    "probability_without": 0.987,
    "enough": True,
    "shots": 0,
    "even_shots": 0,
}


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        (
            {},
            "soft: no further shots are needed: the campaign alone tells drag from wind with "
            "probability 0.99.",
        ),
        (
            {"shots": 1, "even_shots": 3, "probability_without": 0.5},
            "soft: 1 shot (or 3 spread evenly) tells drag from wind with probability 0.99, up "
            "from 0.50.",
        ),
        (
            {"shots": 500, "even_shots": None, "enough": False},
            "soft: 500 shots (or more than 5000 spread evenly) tell drag from wind with "
            "probability 0.99, up from 0.99, less than was asked for.",
        ),
    ],
)
def test_the_answer_says_how_many_shots_are_needed(changed: Json, words: str) -> None:
    assert sentence({**TOLD, **changed}) == words
