"""Filters of tables of shots: by words, by numbers of a column, by both."""

from __future__ import annotations

import pytest

from rigctl.page.shots.table import MEASURED_COLUMNS, Filter, FilterError

COLUMNS = {own["name"]: own["label"] for own in MEASURED_COLUMNS}
ROWS: list[dict[str, object]] = [
    {"number": 1, "state": "analysed", "offset": 4.0, "pressure_a": 40.0, "e": 0.74},
    {"number": 2, "state": "analysed", "offset": 12.5, "pressure_a": 40.0, "e": 0.69},
    {"number": 3, "state": "refused", "offset": 20.0, "pressure_a": 80.0, "e": ""},
]


@pytest.mark.parametrize(
    ("text", "kept"),
    [
        ("", [1, 2, 3]),
        ("refused", [3]),
        ("REF", [3]),
        ("offset > 10", [2, 3]),
        ("offset>=12.5", [2, 3]),
        ("pressure a = 40, e < 0.7", [2]),
        ("pressure_a = 40 and offset < 10", [1]),
        ("analysed, offset > 10", [2]),
        ("state = refused", [3]),
        ("state != refused", [1, 2]),
        ("off > 10", [2, 3]),
        ("e < 1", [1, 2]),
    ],
)
def test_a_filter_keeps_the_rows_that_pass_all_its_clauses(text: str, kept: list[int]) -> None:
    found = Filter.of(text, COLUMNS)
    assert [row["number"] for row in ROWS if found.keeps(row)] == kept


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("height > 10", "“height” names no column: shot, state, pressure a"),
        ("pressure > 10", "names several columns: pressure a, pressure b"),
        ("offset > much", "“much” is no number"),
        ("offset >", "compares nothing"),
        ("> 10", "names no column"),
    ],
)
def test_a_filter_that_cannot_be_meant_says_what_there_is(text: str, said: str) -> None:
    with pytest.raises(FilterError, match=said):
        Filter.of(text, COLUMNS)
