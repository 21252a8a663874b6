"""shots.csv: one row a shot, its settings and any further column."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from analysis.errors import InputError


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
        The other columns.
    """

    shot: int
    time: datetime | None
    numbers: dict[str, float]
    words: dict[str, str]


def read_shot_list(path: Path) -> list[ShotRow]:
    """Read shots.csv.

    A column is numeric when every field of it that is not empty is a finite number.

    Raises
    ------
    InputError
        Absent, without the column `shot`, a row of another length, a shot that is no whole number
        or stands twice, or a time that is not ISO 8601; with the line.
    """
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
    except FileNotFoundError as error:
        raise InputError(path, "no such file") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(path, f"not CSV in UTF-8: {error}") from error
    if not rows or "shot" not in rows[0]:
        raise InputError(path, "the first line must name the columns, 'shot' among them", 1)
    names = rows[0]
    body = [(number, row) for number, row in enumerate(rows[1:], start=2) if row]
    for number, row in body:
        if len(row) != len(names):
            raise InputError(path, f"{len(row)} fields for {len(names)} columns", number)
    numeric = {
        name
        for i, name in enumerate(names)
        if name not in {"shot", "time"} and all(_number(row[i]) is not None for _, row in body)
    }
    shots = [
        _shot(path, number, dict(zip(names, row, strict=True)), numeric) for number, row in body
    ]
    seen: set[int] = set()
    for (number, _), shot in zip(body, shots, strict=True):
        if shot.shot in seen:
            raise InputError(path, f"shot {shot.shot} stands twice", number)
        seen.add(shot.shot)
    return shots


def _number(field: str) -> float | None:
    """Return a number, NaN for an empty field, None for a word."""
    if field.strip() == "":
        return math.nan
    try:
        value = float(field)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _shot(path: Path, line: int, row: dict[str, str], numeric: set[str]) -> ShotRow:
    try:
        shot = int(row.pop("shot"))
    except ValueError as error:
        raise InputError(path, f"shot: {error}", line) from error
    text = row.pop("time", "").strip()
    try:
        time = datetime.fromisoformat(text) if text else None
    except ValueError as error:
        raise InputError(path, f"time: {text!r} is not ISO 8601", line) from error
    values = {name: _number(row[name]) for name in numeric if name in row}
    return ShotRow(
        shot=shot,
        time=time,
        numbers={n: v for n, v in values.items() if v is not None and not math.isnan(v)},
        words={name: word for name, word in row.items() if name not in numeric and word},
    )
