"""shots.csv: one row a shot, its settings and any further column."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from analysis.errors import InputError, counted
from analysis.exchange.numbers_seen import NumbersSeen
from analysis.exchange.rows import each_line, held, not_whole, whole_number
from analysis.setup import CameraSetup

EXPOSURE = "exposure_us"
EXCLUDED, NOTE, TAGS = "excluded", "note", "tags"
WORDS = frozenset({EXCLUDED, NOTE, TAGS})
"""Columns that hold text by definition of the format."""
_DEFINED = re.compile(rf"pressure_\w+_kpa|offset_mm|{EXPOSURE}")
"""Columns that the format defines as numbers."""


@dataclass(frozen=True, slots=True)
class ShotRow:
    """One shot of a campaign.

    Attributes
    ----------
    shot
        Its number in the campaign.
    time
        When it was fired; None where it was not noted.
    numbers
        Numeric columns by name, units in the names; an empty field is absent.
    words
        The other columns; `excluded` is the reason why a person left the shot out of every fit.
    """

    shot: int
    time: datetime | None
    numbers: dict[str, float]
    words: dict[str, str]

    @property
    def is_excluded(self) -> bool:
        """Whether a person left the shot out of every fit."""
        return EXCLUDED in self.words


def exposure_column(camera: CameraSetup) -> dict[str, float]:
    """Return the column of a shot's exposure, us; empty where it is not known."""
    return {} if camera.exposure_s is None else {EXPOSURE: round(1e6 * camera.exposure_s, 9)}


def read_shot_list(path: Path) -> list[ShotRow]:
    """Read shots.csv, with or without the byte order mark that spreadsheets write.

    Pressures, the offset and the exposure are numbers; any other column is numeric when every
    field of it that is not empty is a finite number.

    Raises
    ------
    InputError
        Absent, without the column `shot`, a column that stands twice, a row of another length, a
        shot that is no whole number or stands twice, a time that is not ISO 8601, or no number
        where the format has one; with the line.
    """
    rows = held(path, each_shot_row(path), lambda row: len(row.numbers) + len(row.words))
    return list(rows)


def each_shot_row(path: Path) -> Iterator[ShotRow]:
    """Read shots.csv as `read_shot_list`, a row at a time.

    The file is read twice: whether a column is numeric shows in its last row.
    """
    names, numeric = _columns(path)
    seen = NumbersSeen()
    for number, fields in _body(path):
        row = _shot(path, number, dict(zip(names, fields, strict=True)), numeric)
        if not seen.add(row.shot):
            raise InputError(path, f"shot {row.shot} stands twice", number)
        yield row


def _columns(path: Path) -> tuple[list[str], set[str]]:
    """Return the names of all columns, and of the numeric ones."""
    names = _names(path)
    numeric = {name for name in names if name not in {"shot", "time", *WORDS}}
    for number, fields in _body(path):
        if len(fields) != len(names):
            reason = f"{counted(len(fields), 'field')} for {counted(len(names), 'column')}"
            raise InputError(path, reason, number)
        numeric -= {
            name
            for name, field in zip(names, fields, strict=True)
            if name in numeric and not _DEFINED.fullmatch(name) and _number(field) is None
        }
    return names, numeric


def _names(path: Path) -> list[str]:
    with closing(each_line(path, strict=True)) as lines:
        names = [name.strip() for name in next(lines, (0, []))[1]]
    if "shot" not in names:
        raise InputError(
            path, "the first line must name the columns with commas between, 'shot' among them", 1
        )
    if twice := [name for name, count in Counter(names).items() if count > 1]:
        listed = ", ".join(map(repr, twice))
        raise InputError(path, f"columns that stand more than once: {listed}", 1)
    return names


def _body(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Return the number and the fields of each line that is not blank, but for the first."""
    lines = each_line(path, strict=True)
    next(lines, None)
    return ((number, fields) for number, fields in lines if fields)


def _number(field: str) -> float | None:
    """Return a number, NaN for an empty field, None for a word."""
    if field.strip() == "":
        return math.nan
    try:
        # Python reads 1_2 as twelve; in a table it is a word.
        value = math.inf if "_" in field else float(field)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _shot(path: Path, line: int, row: dict[str, str], numeric: set[str]) -> ShotRow:
    number = row.pop("shot").strip()
    if not whole_number(number):
        raise InputError(path, f"shot: {not_whole(number)}, 0 at least", line)
    text = row.pop("time", "").strip()
    try:
        time = datetime.fromisoformat(text) if text else None
    except ValueError as error:
        raise InputError(path, f"time: {text!r} is not ISO 8601", line) from error
    numbers = {}
    for name, field in row.items():
        if name not in numeric:
            continue
        value = _number(field)
        if value is None:
            raise InputError(path, f"{name}: {field!r} is not a finite number", line)
        if name == EXPOSURE and value < 0:
            raise InputError(path, f"{name}: {field!r} is no exposure, 0 at least", line)
        if not math.isnan(value):
            numbers[name] = value
    return ShotRow(
        shot=int(number),
        time=time,
        numbers=numbers,
        words={name: word for name, word in row.items() if name not in numeric and word},
    )
