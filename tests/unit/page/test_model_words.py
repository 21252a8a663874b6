"""What the model's page says of parameters: expected or not, and how near to the truth."""

from __future__ import annotations

import pytest

from rigctl.challenge import HiddenEffect
from rigctl.game import Game
from rigctl.jobs.duration import Wait
from rigctl.page.model.challenge_panel import (
    answer_from,
    beside_truth,
    choices,
    hidden_size,
    question,
)
from rigctl.page.model.compare import is_unexpected
from rigctl.page.parts.waiting import said_of

HIDDEN = HiddenEffect(effect="drag", amplitude=0.4, unit="1", meaning="drag coefficient")


@pytest.mark.parametrize(
    ("value", "sigma", "unexpected"),
    [(1.61, 0.01, True), (0.5, 0.01, False), (1.02, 0.01, False), (-1.2, 0.05, True)],
)
def test_a_parameter_is_unexpected_unexpected_beyond_three_errors_outside_its_range(
    value: float, sigma: float, unexpected: bool
) -> None:
    assert is_unexpected({"value": value, "sigma": sigma}, (-1.0, 1.0)) is unexpected


def test_what_is_not_determined_or_has_no_range_is_not_doubted() -> None:
    assert not is_unexpected({"value": None, "sigma": None}, (0.0, 1.0))
    assert not is_unexpected({"value": 7.0, "sigma": 0.1}, None)


def test_the_truth_of_a_challenge_stands_beside_the_fit_with_their_distance() -> None:
    fitted = {"e": {"value": 0.7, "sigma": 0.1}, "drag.Cd": {"value": 0.43, "sigma": 0.02}}
    assert beside_truth(HIDDEN, fitted) == ("0.430 ± 0.020", "1.5 σ")


def test_a_hidden_effect_that_nobody_added_has_nothing_beside_it() -> None:
    assert beside_truth(HIDDEN, {"e": {"value": 0.7, "sigma": 0.1}}) == ("not added", "")


def test_a_wait_is_called_longer_than_usual_only_where_it_is_known_what_is_usual() -> None:
    assert said_of(Wait(1.0, None)) == "1 s gone. You can go on reading."
    assert "longer than usual" in said_of(Wait(9.0, None, is_late=True))


def test_hidden_and_answered_sizes_are_said_by_what_they_do() -> None:
    hidden = HiddenEffect(effect="friction-speed", amplitude=0.1, unit="1", meaning="change of mu")
    # 0.1 ln 5 is 16 %.
    assert hidden_size(hidden, 0.74) == "Friction at 5 m/s is 16 % more than at 1 m/s. Size: 0.1."
    unknown = HiddenEffect(effect="warmth", amplitude=-0.1, unit="1/K", meaning="change of e")
    assert hidden_size(unknown, 0.74) == "Size: −0.1 1/K (change of e)."


def test_a_hidden_lift_is_said_as_its_share_of_a_sports_ball_s() -> None:
    hidden = HiddenEffect(effect="magnus-lift", amplitude=1.0, unit="1", meaning="share")
    said = "The air pushes a spinning sphere aside 1 times as hard as it does a sports ball."
    assert hidden_size(hidden, 0.74) == f"{said} Size: 1."


def test_an_answer_begins_with_what_was_added_and_is_asked_for_with_how_sure_one_is() -> None:
    assert answer_from(["drag", "one-of-my-own"]) == ["drag"]
    assert question(["drag"], 0.7) == "Commit to “Air drag”, 70 % sure?"
    assert question(["drag"], None) == "Commit to “Air drag”?"


@pytest.mark.parametrize(
    ("level", "offers_nothing"), [(1, False), (2, True), (3, False), (4, False), (5, True)]
)
def test_nothing_is_an_answer_only_where_the_level_says_that_it_may_be(
    level: int, offers_nothing: bool
) -> None:
    assert ("none" in choices(Game(level, 60))) is offers_nothing
    assert "drag" in choices(Game(level, 60))
