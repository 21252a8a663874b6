"""The sentence above the model: what stands out, and where."""

from __future__ import annotations

from typing import Any

from rigctl.page.model_verdict import sentence

Json = dict[str, Any]


def found(*, row: float = 1.0, cell: float = 1.0, effect: float = 1.0, added: str = "") -> Json:
    """Return an answer of one row, one cell and one effect with these chances."""
    return {
        "prediction_error": 1.5,
        "with": [added] if added else [],
        "stages": [{"quantities": [{"quantity": "normal velocity", "p_familywise": row}]}],
        "cells": [
            {"channel": "spin n", "covariate": "time", "deviation": 2.0, "p_familywise": cell}
        ],
        "candidates": [{"effect": "drag", "seen": True, "like": [], "p_familywise": effect}],
    }


def test_where_no_number_stands_out_all_is_well() -> None:
    lead, rest, good = sentence(found(added="wind"))
    assert (lead, good) == ("With wind nothing stands out.", True)
    assert "1.500 of the noise" in rest


def test_a_cell_that_stands_out_says_where() -> None:
    lead, rest, good = sentence(found(row=1e-9, cell=1e-4, effect=1e-6))
    assert (lead, good) == ("Something is missing.", False)
    assert "most in spin n against time. drag promises most" in rest


def test_a_quantity_that_disagrees_is_named_where_no_cell_stands_out() -> None:
    _, rest, good = sentence(found(row=1e-9, added="wind"))
    assert not good
    assert "most in normal velocity, and no effect that is known explains it" in rest


def test_an_effect_already_in_the_model_is_not_offered_again() -> None:
    said = sentence(found(effect=1e-6, added="drag"))
    assert said[0] == "With drag nothing stands out."
