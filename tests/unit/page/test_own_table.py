"""A table that somebody brings: columns with meanings and units, and rows that are left out."""

from __future__ import annotations

from pathlib import Path

import pytest

from analysis.model.data.gather import gather
from analysis.model.data.tables import ContactTable
from rigctl.errors import AnalysisInputError
from rigctl.measuring.own_table import SETTING, Column, convert, read_table, write_table


def table(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def test_columns_are_recognised_by_their_names_and_units(tmp_path: Path) -> None:
    found = read_table(
        table(tmp_path / "t.csv", "v_n (cm/s);v_n_after_mm_per_s;day\n118,2;874;Mon\n")
    )
    assert found.guessed() == [Column("v_n", "cm/s"), Column("v_n_after", "mm/s"), Column()]
    free = read_table(table(tmp_path / "t.csv", "approach m/s,Rebound mm/s,temp C\n1,800,20\n"))
    assert free.guessed() == [Column("v_n", "m/s"), Column("v_n_after", "mm/s"), Column()]


def test_speeds_come_in_metres_a_second_whatever_their_unit_and_sign(tmp_path: Path) -> None:
    read = read_table(table(tmp_path / "t.csv", "before\tafter\n-118.2\t874\n240,9\t1760\n"))
    found = convert(read, [Column("v_n", "cm/s"), Column("v_n_after", "mm/s")])
    first, second = (impact.speeds for impact in found.impacts)
    assert (first[0], first[2]) == pytest.approx((-1.182, 0.874))
    assert (second[0], second[2]) == pytest.approx((-2.409, 1.76))


def test_heights_give_the_speeds_of_free_fall(tmp_path: Path) -> None:
    read = read_table(table(tmp_path / "t.csv", "fall,rise\n100,64\n"))
    found = convert(read, [Column("fall", "cm"), Column("rise", "cm")])
    before, _, after, _ = found.impacts[0].speeds
    # 1 m of fall takes sqrt(2 / g) and ends at g times that.
    assert -before == pytest.approx(9.80665 * (2 / 9.80665) ** 0.5)
    assert after / -before == pytest.approx(0.8)


def test_rows_that_are_no_impact_are_left_out_with_line_and_reason(tmp_path: Path) -> None:
    text = "before,after\n1.0,0.8\n1.0,1.2\nfast,0.5\n,0.5\n\n2.0,1.5\n"
    found = convert(read_table(table(tmp_path / "t.csv", text)), SPEEDS)
    assert [impact.shot for impact in found.impacts] == [1, 2]
    assert [line for line, _ in found.left_out] == [3, 4, 5]
    reasons = [reason for _, reason in found.left_out]
    assert reasons[0] == "it parts faster (1.2 m/s) than it met (1 m/s)"
    assert reasons[1] == "before: “fast” is no number"
    assert reasons[2] == "no approach speed"


SPEEDS = [Column("v_n", "m/s"), Column("v_n_after", "m/s")]


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ([Column("v_n", "m/s"), Column()], "says how fast it was after the impact"),
        ([Column("v_n", "m/s"), Column("v_n", "m/s")], "“approach speed” is chosen for two"),
        ([Column("v_n", "m/s"), Column("fall", "m")], "says how fast it was before the impact"),
    ],
)
def test_a_choice_that_says_too_little_or_too_much_is_refused(
    tmp_path: Path, columns: list[Column], said: str
) -> None:
    read = read_table(table(tmp_path / "t.csv", "one,two\n1,2\n"))
    with pytest.raises(AnalysisInputError) as refused:
        convert(read, columns)
    assert said in refused.value.sentence()


@pytest.mark.parametrize("text", ["", "only names\n", "a,b\n1,2,3\n"])
def test_what_is_no_table_is_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(AnalysisInputError):
        read_table(table(tmp_path / "t.csv", text))


def test_what_is_written_is_read_by_the_model(tmp_path: Path) -> None:
    text = "before,after,temp (C)\n" + "".join(
        f"{v},{(0.8 + 0.01 * (-1) ** v) * v},{20 + v}\n" for v in range(1, 10)
    )
    found = convert(read_table(table(tmp_path / "t.csv", text)), [*SPEEDS, Column(SETTING)])
    write_table(tmp_path / "campaign", "steel", found, 0.02, plate=False)
    name, data = gather(tmp_path / "campaign")
    assert name == "steel"
    assert isinstance(data, ContactTable)
    assert data.covariates["temp_c"].tolist() == [21.0 + k for k in range(9)]
