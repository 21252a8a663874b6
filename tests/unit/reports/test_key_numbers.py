"""The numbers at the top of a report: the better estimate of two leads."""

from __future__ import annotations

from analysis.quantity import Quantity
from rigctl.reports.page import better


def test_the_estimate_with_the_smaller_error_leads_and_says_which_it_is() -> None:
    rough, fine = Quantity(0.76, 0.02, "1"), Quantity(0.74, 0.0002, "1")
    assert better(rough, fine) == (fine, "two lines, by regression")
    assert better(fine, rough) == (fine, "fit to all that was measured")


def test_what_is_not_determined_leads_never() -> None:
    rough, open_one = Quantity(0.76, 0.02, "1"), Quantity.undetermined("1")
    assert better(open_one, rough) == (rough, "two lines, by regression")
    assert better(open_one, None) is None
