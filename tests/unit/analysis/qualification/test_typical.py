"""Relative changes by a constant Z, on made-up impacts."""

from types import SimpleNamespace
from typing import Any

import pytest

from analysis.qualification.depth import BothWays, typical_errors
from analysis.quantity import Quantity


def impact(v_n: float, v_n_after: float, v_s: float, v_s_after: float) -> Any:
    values = {"v_n": v_n, "v_n_after": v_n_after, "v_s": v_s, "v_s_after": v_s_after}
    values["e"] = -v_n_after / v_n
    return SimpleNamespace(**{name: Quantity(v, 0.001, "m/s") for name, v in values.items()})


def test_a_change_is_relative_to_the_measured_value_and_of_v_s_after_to_v_s() -> None:
    both = BothWays(impact(-2.0, 1.5, 4.0, 0.0), impact(-2.02, 1.5, 3.96, 0.02))
    assert both.relative("v_n") == pytest.approx(0.01)
    assert both.relative("v_n_after") == 0.0
    assert both.relative("v_s") == pytest.approx(-0.01)
    assert both.relative("v_s_after") == pytest.approx(0.005)
    assert both.relative("e") == pytest.approx(1 / 1.01 - 1)


def test_median_and_largest_are_of_the_size_whatever_the_sign() -> None:
    one = impact(-2.0, 1.5, 4.0, 3.0)
    changed = [impact(-2.0 * (1 + c), 1.5, 4.0, 3.0) for c in (0.01, -0.03, 0.002)]
    errors = typical_errors([BothWays(one, other) for other in changed])
    assert errors["v_n"] == pytest.approx((0.01, 0.03))
