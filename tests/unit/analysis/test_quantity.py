import pytest

from analysis.quantity import Quantity


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
