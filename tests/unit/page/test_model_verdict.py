"""The sentence above the model: what stands out, and where."""

from __future__ import annotations

from typing import Any

from analysis.model.verdict.standing import Word
from rigctl.page.model.verdict import doubted, sentence

Json = dict[str, Any]


def found(
    *,
    row: float = 1.0,
    cell: float = 1.0,
    effect: float = 1.0,
    added: str = "",
    shots: int = 30,
    shared: bool = True,
    covariate: str = "time",
) -> Json:
    """Return an answer of one row, one cell and one effect with these chances."""
    return {
        "shots": shots,
        "prediction_error": 1.5,
        "with": [added] if added else [],
        "stages": [
            {"quantities": [{"quantity": "normal velocity", "p_familywise": row, "shared": True}]}
        ],
        "cells": [{"p_familywise": cell, "shared": shared}],
        "findings": [{"channel": "spin n", "covariate": covariate, "p_familywise": cell}],
        "candidates": [
            {
                "effect": "drag",
                "seen": True,
                "of_measurement": False,
                "like": [],
                "p_familywise": effect,
            }
        ],
    }


def test_where_no_number_stands_out_all_is_well() -> None:
    lead, rest, good = sentence([found(added="wind")])
    assert (lead, good) == ("With wind nothing stands out.", True)
    assert "1.50 times the noise" in rest


def test_a_cell_that_stands_out_says_where() -> None:
    lead, rest, good = sentence([found(row=1e-9, cell=1e-4, effect=1e-6)])
    assert (lead, good) == ("Something is missing.", False)
    assert "most surely in spin n against time. drag lowers it most" in rest


def test_a_mean_that_stands_out_is_named_as_one() -> None:
    _, rest, _ = sentence([found(row=1e-9, cell=1e-4, effect=1e-6, covariate="always")])
    assert "most surely in spin n, mean of all shots." in rest


def test_a_quantity_that_disagrees_is_named_where_no_cell_stands_out() -> None:
    _, rest, good = sentence([found(row=1e-9, added="wind")])
    assert not good
    assert "most surely in normal velocity, and no effect that is known explains it" in rest


def test_an_effect_already_in_the_model_is_not_offered_again() -> None:
    said = sentence([found(effect=1e-6, added="drag")])
    assert said[0] == "With drag nothing stands out."


def test_of_one_shot_nothing_is_said_but_how_many_would_tell() -> None:
    lead, rest, good = sentence([found(row=1e-9, cell=1e-9, effect=1e-3, shots=1)])
    assert (lead, good) == ("Too few shots to tell.", None)
    assert "1 shot is too few" in rest
    assert "Add 4 at least, and better 12" in rest


def test_what_two_of_a_few_shots_carry_is_no_finding() -> None:
    lead, rest, good = sentence([found(row=1e-9, cell=1e-9, added="wind", shots=10, shared=False)])
    assert (lead, good) == ("With wind nothing more is sure.", None)
    assert "may be errors of single shots" in rest


def test_what_most_of_a_few_shots_show_is_one() -> None:
    assert sentence([found(cell=1e-9, shots=10)])[0] == "Something is missing."


def test_of_many_shots_what_stands_out_is_said_whoever_carries_it() -> None:
    assert sentence([found(cell=1e-9, shared=False)])[0] == "Something is missing."


def test_stated_numbers_are_in_doubt_only_once_nothing_else_is_missing() -> None:
    assert doubted(1, Word.FLOOR) == "1 stated number of the set-up is in doubt"
    assert doubted(16, Word.ALIKE) == "16 stated numbers of the set-up are in doubt"
    for word in (Word.MISSING, Word.UNEXPLAINED):
        assert "bent by what is missing: look again once it is added" in doubted(16, word)
    # Whether something is missing these shots do not say: it would bend them too.
    for word in (Word.FEW, Word.UNSURE):
        assert doubted(1, word).endswith(
            "fits badly: if something is missing, more shots would show it"
        )
    said = {word: doubted(2, word) for word in Word}
    assert {word for word in said if "in doubt" in said[word]} == {Word.FLOOR, Word.ALIKE}


def test_what_is_named_first_is_called_surest_only_where_it_is() -> None:
    one = found(row=1e-9, cell=1e-9)
    other = {**one["findings"][0], "covariate": "ln v_n"}
    assert "it shows most surely in" in sentence([one])[1]
    said = sentence([one], first=lambda _found, _standing: [other, *one["findings"]])[1]
    assert "it shows in" in said
