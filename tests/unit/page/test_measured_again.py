"""A shot whose numbers a further analysis has changed says so."""

from __future__ import annotations

from typing import Any

from rigctl.page.shots.view import measured_again


def result(e: float, method: str = "photometric", status: str = "measured") -> dict[str, Any]:
    """Return a result with an e, its error a thousandth, and a beta of one half."""
    numbers = {"e": {"value": e, "sigma": 0.001}, "beta": {"value": 0.5, "sigma": 0.01}}
    return {"status": status, "method": method, **numbers}


def test_what_has_changed_is_said_with_both_values_and_what_has_not_is_not() -> None:
    said = measured_again(result(0.741), result(0.739))
    assert said == (
        "Measured again, with what is known of its spheres by now: "
        "bounce e was 0.7390\u00a0±\u00a00.0010, is 0.7410\u00a0±\u00a00.0010."
    )
    assert "by the method thesis:" in measured_again(result(0.741, "thesis"), result(0.739))


def test_nothing_is_said_of_the_first_result_nor_where_both_read_alike() -> None:
    assert measured_again(result(0.741), {}) == ""
    assert measured_again(result(0.74101), result(0.74099)) == ""
    assert measured_again(result(0.741), result(0.739, status="refused")) == ""
