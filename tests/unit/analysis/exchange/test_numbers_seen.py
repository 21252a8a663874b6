"""Numbers of shots are told from those that a table has had, in whatever order they come."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from analysis.exchange.numbers_seen import NumbersSeen


@given(st.lists(st.integers(-3, 12)))
def test_a_number_is_there_for_the_first_time_exactly_once(numbers: list[int]) -> None:
    seen = NumbersSeen()
    assert [seen.add(n) for n in numbers] == [n not in numbers[:k] for k, n in enumerate(numbers)]
