"""Hints name the nearest physics, and say that they are hints."""

from __future__ import annotations

import pytest

from analysis.model.proposals.document import HINTS, hint_for


@pytest.mark.parametrize(
    ("slot", "argument", "shape", "rising", "says"),
    [
        ("e", "temperature_c", "linear", False, "glass transition"),
        ("e", "temperature_c", "linear", True, "trapped gas"),
        ("mu", "spin", "linear", False, "Contensou"),
        ("mu", "speed_s", "exponential", False, "Stribeck"),
        ("flight", "distance", "power", True, "1/d^4"),
    ],
)
def test_known_causes_are_named(
    slot: str, argument: str, shape: str, says: str, *, rising: bool
) -> None:
    found = hint_for(slot, argument, shape, rising=rising)
    assert found is not None
    assert found.startswith("hint, not a finding: ")
    assert says in found


def test_where_nothing_is_known_nothing_is_said() -> None:
    assert hint_for("beta0", "operator_id", "step", rising=True) is None
    assert hint_for("e", "humidity*temperature_c", "linear", rising=True) is None


def test_every_hint_has_a_cause_and_a_source() -> None:
    assert all(hint.cause and hint.source for hint in HINTS)
