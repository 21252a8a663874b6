"""Cells of tables as other programs write them: lines, separators, and the numbers in them."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from pathlib import Path

from analysis.errors import InputError

MOST_BYTES = 50_000_000
NONE = {"", "nan", "na", "n/a", "null", "none", "-"}
"""Cells of a frame in which nothing was found."""
NUMBER = re.compile(r"[+-]?[\d.,]+(?:e[+-]?\d+)?", re.IGNORECASE)
BY_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(?:,\d{3})+(?:\.\d*)?")
"""A number whose commas may part thousands."""
CLOCK = re.compile(r"(?:(\d+):)?(\d{1,2}):(\d{1,2}(?:\.\d*)?)")
"""Hours, minutes and seconds of a time code."""
COMMENT = re.compile(r"[#%]+ *")
"""Before a line of names, where a program writes it as a comment."""
EXCHANGED = str.maketrans(",.", ".,")


def read_lines(path: Path) -> list[str]:
    """Return the lines of a text.

    Raises
    ------
    InputError
        It cannot be read, is too large, or is no text.
    """
    try:
        if path.stat().st_size > MOST_BYTES:
            raise InputError(path, f"is larger than a table of {MOST_BYTES // 10**6} MB")
        data = path.read_bytes()
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror or error}") from error
    if data[:2] in {b"\xff\xfe", b"\xfe\xff"}:
        return data.decode("utf-16", errors="replace").splitlines()
    if b"\0" in data:
        raise InputError(path, "is no text")
    try:
        return data.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        return data.decode("latin-1").splitlines()


def split(lines: Sequence[str], separator: str) -> list[list[str]]:
    """Return the cells of lines, numbers with a decimal point and nothing between thousands.

    A comma within a cell is a decimal comma, unless the table's numbers show that commas, or
    points, part thousands: 1,012.5 and 1.012,5. Where they show both, cells stay as they are.
    """
    plain = [COMMENT.sub("", line, count=1) if line[:1] in "#%" else line for line in lines]
    rows = list(csv.reader(plain, delimiter=separator, skipinitialspace=separator == " "))
    commas = [c.strip() for row in rows for c in row if "," in c and NUMBER.fullmatch(c.strip())]
    if not commas:
        return [[cell.replace(",", ".") for cell in row] for row in rows]
    points = [c.strip() for row in rows for c in row if "." in c and NUMBER.fullmatch(c.strip())]
    by_comma = _part_thousands(commas, points)
    by_point = _part_thousands(
        *([c.translate(EXCHANGED) for c in each] for each in (points, commas))
    )
    if by_comma and by_point:
        return rows
    gone = "," if by_comma else "." if by_point else ""
    return [
        [(c.replace(gone, "") if NUMBER.fullmatch(c.strip()) else c).replace(",", ".") for c in row]
        for row in rows
    ]


def _part_thousands(commas: Sequence[str], points: Sequence[str]) -> bool:
    """Return whether commas part thousands, by numbers with commas and those with points."""
    return bool(points and commas) and all(BY_THOUSANDS.fullmatch(cell) for cell in commas)


def number(row: Sequence[str], index: int) -> float:
    """Return the number in a cell, nan where there is none."""
    try:
        return float(row[index].strip().replace("\u2212", "-"))
    except (ValueError, IndexError):
        return math.nan


def moment(row: Sequence[str], index: int) -> float:
    """Return the time in a cell, that of a time code h:mm:ss.fff in s; nan where there is none."""
    code = time_code(row, index)
    return number(row, index) if code is None else code


def time_code(row: Sequence[str], index: int) -> float | None:
    """Return the s of a time code h:mm:ss.fff; None: the cell holds none."""
    found = CLOCK.fullmatch(row[index].strip()) if index < len(row) else None
    if found is None:
        return None
    return 3600.0 * int(found[1] or 0) + 60.0 * int(found[2]) + float(found[3])


def is_no_number(cell: str) -> bool:
    """Return whether something stands in a cell, and no number."""
    return cell.strip().lower() not in NONE and not math.isfinite(moment([cell], 0))
