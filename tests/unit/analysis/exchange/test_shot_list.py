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
        ("shot;time\n1;\n", 1, "with commas between"),
        ("shot,offset_mm\n1,2\n2\n", 3, "1 field for 2 columns"),
        ("shot,offset_mm\n1,2,3\n", 2, "3 fields for 2 columns"),
        ("shot\n1\nb\n", 3, "'b'"),
        ("shot\n1.5\n", 2, "'1.5'"),
        ("shot\n1\n2\n1\n", 4, "shot 1 stands twice"),
        ("shot\n1\n-2\n", 3, "'-2' is not a whole number, 0 at least"),
        ("shot\n1_0\n", 2, "'1_0'"),
        ("shot,offset_mm,offset_mm\n1,2,3\n", 1, "more than once: 'offset_mm'"),
        ("shot,offset_mm, offset_mm\n1,2,3\n", 1, "more than once: 'offset_mm'"),
        ("shot,offset_mm\n1,2\n2,abc\n", 3, "offset_mm: 'abc' is not a finite number"),
        ("shot,pressure_a_kpa\n1,nan\n", 2, "pressure_a_kpa: 'nan'"),
        ("shot,pressure_b_kpa\n1,1e999\n", 2, "pressure_b_kpa: '1e999'"),
        ("shot,pressure_b_kpa\n1,4_0\n", 2, "pressure_b_kpa: '4_0'"),
        ("shot,exposure_us\n1,long\n", 2, "exposure_us: 'long'"),
        ("shot,exposure_us\n1,-200\n", 2, "exposure_us: '-200' is no exposure"),
        ('shot,note\n1,"two\nlines"\n2,x\nb,y\n', 5, "'b'"),
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


@pytest.mark.parametrize("word", ["inf", "nan", "1e999", "1_0"])
def test_what_is_not_a_finite_number_makes_a_further_column_one_of_words(
    tmp_path: Path, word: str
) -> None:
    (row,) = read_shot_list(written(tmp_path, f"shot,batch\n1,{word}\n"))
    assert row.numbers == {}
    assert row.words == {"batch": word}


def test_a_table_saved_by_a_spreadsheet_is_read(tmp_path: Path) -> None:
    path = tmp_path / "shots.csv"
    path.write_bytes(b"\xef\xbb\xbf" + GOOD.replace("\n", "\r\n").encode())
    assert read_shot_list(path) == read_shot_list(written(tmp_path, GOOD))


def test_a_quote_that_is_never_closed_is_refused_and_swallows_no_rows(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not CSV"):
        read_shot_list(written(tmp_path, 'shot,note\n1,"hit\n2,soft\n'))


def test_an_absent_file_and_one_that_is_not_text_are_named(tmp_path: Path) -> None:
    path = tmp_path / "shots.csv"
    with pytest.raises(InputError, match="no such file"):
        read_shot_list(path)
    path.write_bytes(b"shot\n\xff\xfe\n")
    with pytest.raises(InputError, match="not CSV in UTF-8"):
        read_shot_list(path)
