from datetime import UTC, datetime
from pathlib import Path

import pytest

from analysis.errors import InputError
from analysis.exchange.shot_list import ShotRow, read_shot_list

GOOD = """\
shot,time,pressure_a_kpa,temperature_c,operator,room
1,2026-01-01T09:00:00Z,25,20.5,Ana,7
2,,30,,Ben,12
10,2026-01-01T09:05:00+02:00,35.5,21,,B4
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "shots.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_column_is_numeric_when_every_field_of_it_is_a_number(tmp_path: Path) -> None:
    first, second, third = read_shot_list(written(tmp_path, GOOD))
    assert first == ShotRow(
        1,
        datetime(2026, 1, 1, 9, tzinfo=UTC),
        {"pressure_a_kpa": 25.0, "temperature_c": 20.5},
        {"operator": "Ana", "room": "7"},
    )
    assert second.time is None
    assert second.numbers == {"pressure_a_kpa": 30.0}
    assert third.words == {"room": "B4"}
    assert third.time == datetime(2026, 1, 1, 7, 5, tzinfo=UTC)


def test_an_empty_field_is_absent_and_never_zero(tmp_path: Path) -> None:
    rows = read_shot_list(written(tmp_path, "shot,offset_mm\n1,\n2,4\n"))
    assert [row.numbers for row in rows] == [{}, {"offset_mm": 4.0}]


def test_blank_lines_are_passed_over_and_quotes_may_hold_commas(tmp_path: Path) -> None:
    rows = read_shot_list(written(tmp_path, 'shot,note\n1,"hit, hard"\n\n2,soft\n'))
    assert [(row.shot, row.words["note"]) for row in rows] == [(1, "hit, hard"), (2, "soft")]


@pytest.mark.parametrize(
    ("text", "line", "reason"),
    [
        ("", 1, "'shot' among them"),
        ("number,time\n1,\n", 1, "'shot' among them"),
        ("shot,offset_mm\n1,2\n2\n", 3, "1 fields for 2 columns"),
        ("shot,offset_mm\n1,2,3\n", 2, "3 fields for 2 columns"),
        ("shot\n1\nb\n", 3, "'b'"),
        ("shot\n1.5\n", 2, "'1.5'"),
        ("shot\n1\n2\n1\n", 4, "shot 1 stands twice"),
        ("shot,time\n1,yesterday\n", 2, "'yesterday' is not ISO 8601"),
    ],
)
def test_a_mistake_is_named_with_its_line(
    tmp_path: Path, text: str, line: int, reason: str
) -> None:
    path = written(tmp_path, text)
    with pytest.raises(InputError) as fault:
        read_shot_list(path)
    assert (fault.value.path, fault.value.line) == (str(path), line)
    assert reason in fault.value.reason
    assert f"line {line}" in str(fault.value)


@pytest.mark.parametrize("infinite", ["inf", "nan", "1e999"])
def test_a_number_that_is_not_finite_is_a_word(tmp_path: Path, infinite: str) -> None:
    (row,) = read_shot_list(written(tmp_path, f"shot,offset_mm\n1,{infinite}\n"))
    assert row.numbers == {}
    assert row.words == {"offset_mm": infinite}


def test_an_absent_file_and_one_that_is_not_text_are_named(tmp_path: Path) -> None:
    path = tmp_path / "shots.csv"
    with pytest.raises(InputError, match="no such file"):
        read_shot_list(path)
    path.write_bytes(b"shot\n\xff\xfe\n")
    with pytest.raises(InputError, match="not CSV in UTF-8"):
        read_shot_list(path)
