import json
import math
from typing import Any

import pytest
from pydantic import ValidationError

from analysis.quantity import Quantity
from analysis.schema import codec
from analysis.schema.verdict import Nuisance

GOOD = {"value": 0.9, "sigma": 0.1, "unit": "1"}


@pytest.mark.parametrize(
    ("value", "sigma", "expected"),
    [
        (0.73842, 0.0033, "0.7384(33)"),
        (-2.7311, 0.012, "-2.731(12)"),
        (10.0, 0.25, "10.00(25)"),
        (1234.5, 37.0, "1234(37)"),
        (0.5, 0.0, "0.5"),
        (0.5, float("nan"), "0.5"),
    ],
)
def test_two_digits_of_the_error_stand_in_brackets(
    value: float, sigma: float, expected: str
) -> None:
    assert Quantity(value, sigma, "1").concise() == expected


def test_parts_of_an_error_stand_beside_the_whole_where_they_are_told_apart() -> None:
    told = Quantity(1.0, 0.05, "m/s", common=0.03)
    assert told.own == pytest.approx(0.04)
    document = told.rescaled(1e3, "mm/s").to_json()
    assert document.pop("sigma_own") == pytest.approx(40.0)
    assert document == {"value": 1e3, "sigma": 50.0, "sigma_common": 30.0, "unit": "mm/s"}


def test_the_unit_travels_along() -> None:
    assert Quantity(1.0, 0.1, "m/s").to_json() == {"value": 1.0, "sigma": 0.1, "unit": "m/s"}


@pytest.mark.parametrize(
    "fault",
    [
        {"value": "0.9"},
        {"value": True},
        {"value": [0.9]},
        {"value": math.nan},
        {"value": 10**400},
        {"sigma": -0.1},
        {"sigma": math.nan},
        {"sigma": math.inf},
        {"sigma": "0.1"},
        {"sigma_common": -0.1},
        {"sigma_common": {}},
        {"unit": None},
        {"unit": 1},
        {"value": None, "unit": None},
    ],
)
def test_a_document_with_something_else_in_a_quantity_is_refused(fault: dict[str, Any]) -> None:
    (key, *_) = fault if len(fault) == 1 else ["unit"]
    with pytest.raises(ValueError, match=rf"^{key}: "):
        Quantity.from_json({**GOOD, **fault})
    nuisance = {"nuisance": "drag.Cd", "stated": GOOD, "found": {**GOOD, **fault}, "pull": 0.0}
    with pytest.raises(ValidationError, match=key):
        codec.read(Nuisance, nuisance)


@pytest.mark.parametrize("key", ["value", "sigma", "unit"])
def test_a_quantity_without_a_key_is_refused_by_the_field_and_the_key(key: str) -> None:
    part = {k: v for k, v in GOOD.items() if k != key}
    nuisance = {"nuisance": "drag.Cd", "stated": GOOD, "found": part, "pull": 0.0}
    with pytest.raises(ValidationError, match=rf"found\s.*lacks {key}"):
        codec.read(Nuisance, nuisance)


@pytest.mark.parametrize("sigma", [math.nan, -1.0])
def test_an_error_that_is_none_enters_no_document(sigma: float) -> None:
    good = Quantity(0.42, 0.2, "1")
    with pytest.raises(ValidationError, match=r"sigma: .* is no standard error"):
        Nuisance("drag.Cd", good, Quantity(0.4, sigma, "1"), 0.0)


def test_an_error_without_bound_is_null_in_json_and_comes_back() -> None:
    unbound = Quantity(0.4, math.inf, "1", common=0.1)
    text = json.dumps(unbound.to_json(), allow_nan=False)
    assert json.loads(text) == {"value": 0.4, "sigma": None, "unit": "1"}
    assert Quantity.from_json(json.loads(text)).sigma == math.inf
