"""impacts.csv is read as it stands, and what is wrong in it is named by line, field and value."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.errors import InputError
from analysis.exchange.impact_table import ImpactRow, read_impacts

HEAD = "shot,v_n,v_s,v_n_after,v_s_after"
SIGMAS = "sigma_v_n,sigma_v_s,sigma_v_n_after,sigma_v_s_after"
GOOD = "1,-2,1.5,1.4,-0.3,0.01,0.02,0.03,0.04"


def read(folder: Path, *lines: str) -> list[ImpactRow]:
    (folder / "impacts.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return read_impacts(folder / "impacts.csv")


def refused(folder: Path, line: str) -> str:
    with pytest.raises(InputError) as caught:
        read(folder, f"{HEAD},{SIGMAS}", GOOD, line)
    assert caught.value.line == 3
    return caught.value.reason


def test_a_row_holds_speeds_and_errors(tmp_path: Path) -> None:
    (row,) = read(tmp_path, f"{HEAD},{SIGMAS}", GOOD)
    assert row == ImpactRow(1, (-2.0, 1.5, 1.4, -0.3), (0.01, 0.02, 0.03, 0.04))


def test_shots_come_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    rows = read(tmp_path, HEAD, "5,-1,0,0.7,0", "2,-1,0,0.7,0")
    assert [row.shot for row in rows] == [2, 5]


def test_errors_may_be_left_out_with_or_without_their_columns(tmp_path: Path) -> None:
    for lines in ((HEAD, "1,-2,1,1.4,0.3"), (f"{HEAD},{SIGMAS}", "1,-2,1,1.4,0.3,,,,")):
        (row,) = read(tmp_path, *lines)
        assert row.sigmas == (None,) * 4


def test_a_number_that_was_not_measured_needs_no_error(tmp_path: Path) -> None:
    (row,) = read(tmp_path, f"{HEAD},{SIGMAS}", "1,-2,,1.4,,0.01,,0.03,")
    assert math.isnan(row.speeds[1])
    assert row.sigmas == (0.01, None, 0.03, None)


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("2,2,1.5,1.4,0,1,1,1,1", "v_n: 2.0 is not negative, as it is before contact"),
        ("2,,1.5,1.4,0,1,1,1,1", "v_n: empty; the normal velocity before contact must be there"),
        ("2,-2,-1.5,1.4,0,1,1,1,1", "v_s: -1.5 is negative; it is 0 at least"),
        ("2,-2,1.5,-1.4,0,1,1,1,1", "v_n_after: -1.4 is negative; it is 0 at least"),
        ("2,-2,1.5,1.4,0,1,-1,1,1", "sigma_v_s: -1.0 is not a standard error, being negative"),
        ("2,-2,1.5,1.4,x,1,1,1,1", "v_s_after: 'x' is not a number"),
        ("1,-2,1.5,1.4,0,1,1,1,1", "shot 1 stands twice"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, line: str, reason: str) -> None:
    assert refused(tmp_path, line) == reason


def test_errors_of_some_numbers_only_are_refused(tmp_path: Path) -> None:
    reason = refused(tmp_path, "2,-2,1.5,1.4,0,1,1,,1")
    assert reason.startswith("sigma_v_n_after: not stated, where other errors are; state all")


def test_an_unknown_column_is_refused_with_those_that_may_be(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"must be shot,v_n.*and may be sigma_v_n") as caught:
        read(tmp_path, f"{HEAD},e", "1,-2,1.5,1.4,0,0.7")
    assert caught.value.line == 1


@given(st.tuples(st.floats(-10, -1e-3), *[st.floats(0, 10)] * 2, st.floats(-10, 10)))
def test_every_number_comes_back_as_it_was_written(
    tmp_path_factory, speeds: tuple[float, ...]
) -> None:
    folder = tmp_path_factory.mktemp("impacts")
    (row,) = read(folder, HEAD, ",".join(["1", *map(repr, speeds)]))
    assert row.speeds == speeds
