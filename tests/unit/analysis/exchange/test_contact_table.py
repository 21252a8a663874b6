"""contacts.csv is read as it stands, and what is wrong in it is named by line, field and value."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.errors import InputError
from analysis.exchange.contact_table import ContactRow, read_contacts

STATE = [f"{kind}{sphere}_{axis}" for kind in "vw" for sphere in "ab" for axis in "xyz"]
COLUMNS = [
    *("shot", "nx", "ny", "nz"),
    *STATE,
    *(f"{name}_after" for name in STATE),
    *("sigma_v_m_per_s", "sigma_w_rad_per_s"),
]
GOOD = {
    **dict.fromkeys(COLUMNS, "0"),
    **{"shot": "1", "ny": "1", "va_y": "1.5", "vb_y": "-1.5", "va_y_after": "-1"},
    **{"vb_y_after": "1", "wa_z": "20", "sigma_v_m_per_s": "0.004", "sigma_w_rad_per_s": "0.5"},
}


def written(folder: Path, *rows: dict[str, str], columns: list[str] = COLUMNS) -> Path:
    path = folder / "contacts.csv"
    lines = [columns, *([row[name] for name in columns] for row in rows)]
    path.write_text("\n".join(",".join(line) for line in lines) + "\n", encoding="utf-8")
    return path


def read(folder: Path, *rows: dict[str, str], plate: bool = False) -> list[ContactRow]:
    return read_contacts(written(folder, *rows), plate=plate)


def refused(folder: Path, changes: dict[str, str], *, plate: bool = False) -> str:
    with pytest.raises(InputError) as caught:
        read(folder, GOOD, {**GOOD, "shot": "2", **changes}, plate=plate)
    assert caught.value.line == 3
    return caught.value.reason


def test_a_row_holds_normal_states_and_errors(tmp_path: Path) -> None:
    (row,) = read(tmp_path, GOOD)
    assert (row.shot, row.normal) == (1, (0.0, 1.0, 0.0))
    assert row.before == (0, 1.5, 0, 0, -1.5, 0, 0, 0, 20, 0, 0, 0)
    assert row.after == (0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0)
    assert (row.sigma_v, row.sigma_w) == (0.004, 0.5)


def test_columns_may_stand_in_any_order_and_shots_too(tmp_path: Path) -> None:
    path = written(tmp_path, {**GOOD, "shot": "7"}, {**GOOD, "shot": "3"}, columns=COLUMNS[::-1])
    assert [row.shot for row in read_contacts(path, plate=False)] == [3, 7]


def test_a_field_that_was_not_measured_is_not_a_number(tmp_path: Path) -> None:
    (row,) = read(tmp_path, {**GOOD, "wa_x": "", "vb_z_after": ""})
    assert math.isnan(row.before[6])
    assert math.isnan(row.after[5])


def test_errors_may_be_left_out_with_their_columns(tmp_path: Path) -> None:
    path = written(tmp_path, GOOD, columns=COLUMNS[:-2])
    (row,) = read_contacts(path, plate=False)
    assert (row.sigma_v, row.sigma_w) == (None, None)


def test_the_error_of_spins_is_not_needed_where_no_spin_was_measured(tmp_path: Path) -> None:
    spins = [name for name in COLUMNS if name.startswith("w")]
    (row,) = read(tmp_path, {**GOOD, **dict.fromkeys(spins, ""), "sigma_w_rad_per_s": ""})
    assert (row.sigma_v, row.sigma_w) == (0.004, None)


def test_a_zero_error_is_one_that_is_not_stated(tmp_path: Path) -> None:
    zero = {**GOOD, "sigma_v_m_per_s": "0", "sigma_w_rad_per_s": "0"}
    (row,) = read(tmp_path, zero)
    assert (row.sigma_v, row.sigma_w) == (None, None)


def test_errors_stated_in_some_lines_only_are_refused(tmp_path: Path) -> None:
    reason = refused(tmp_path, {"sigma_w_rad_per_s": ""})
    assert reason.startswith("sigma_w_rad_per_s: not stated, where other errors are")


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"nx": "0.5"}, "nx..nz: a normal of length 1.118, not 1"),
        ({"ny": ""}, "nx..nz: empty; the normal must be there"),
        ({"va_x": ""}, "va_x: empty; every velocity before contact must be there"),
        ({"wb_z": "fast"}, "wb_z: 'fast' is not a number"),
        ({"wb_z": "inf"}, "wb_z: 'inf' is not finite"),
        ({"shot": "two"}, "shot: 'two' is not a whole number"),
        ({"shot": "1"}, "shot 1 stands twice"),
        ({"ny": "-1"}, "the bodies part at 3 m/s before contact, along the normal from a to b"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, changes: dict[str, str], reason: str) -> None:
    assert refused(tmp_path, changes) == reason


def test_a_plate_is_at_rest_whether_that_is_said_or_not(tmp_path: Path) -> None:
    at_rest = [name for name in STATE if name[1] == "b"]
    silent = dict.fromkeys([*at_rest, *(f"{name}_after" for name in at_rest)], "")
    for fields in (silent, dict.fromkeys(silent, "0")):
        (row,) = read(tmp_path, {**GOOD, **fields}, plate=True)
        assert row.before[3:6] == row.before[9:] == row.after[3:6] == row.after[9:] == (0, 0, 0)


def test_a_plate_that_moves_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"line 2: vb_y: -1\.5 for a plate, which is at rest"):
        read(tmp_path, GOOD, plate=True)


def test_a_missing_and_an_unknown_column_are_refused(tmp_path: Path) -> None:
    for columns in (COLUMNS[:3] + COLUMNS[4:], [*COLUMNS, "shot"]):
        path = written(tmp_path, GOOD, columns=columns)
        with pytest.raises(InputError, match="line 1: the columns must be shot,nx,ny,nz"):
            read_contacts(path, plate=False)


def test_a_short_line_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path, GOOD)
    path.write_text(path.read_text(encoding="utf-8") + "2,0,1\n", encoding="utf-8")
    with pytest.raises(InputError, match="line 3: 3 fields for 30 columns"):
        read_contacts(path, plate=False)


def test_an_absent_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"contacts\.csv: no such file"):
        read_contacts(tmp_path / "contacts.csv", plate=False)


@given(st.lists(st.floats(-1e3, 1e3), min_size=12, max_size=12))
def test_every_number_comes_back_as_it_was_written(tmp_path_factory, after: list[float]) -> None:
    names = [f"{name}_after" for name in STATE]
    folder = tmp_path_factory.mktemp("contacts")
    (row,) = read(folder, {**GOOD, **dict(zip(names, map(repr, after), strict=True))})
    assert row.after == tuple(after)
