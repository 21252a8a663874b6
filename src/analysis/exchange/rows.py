"""Tables of numbers: rows with their line, for errors that name it; and the writing of tables."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TextIO, TypeVar

from analysis.errors import InputError, counted
from analysis.files import file_limits

if TYPE_CHECKING:
    from _csv import Writer

    from analysis.shot import MeasuredShot

Row = TypeVar("Row")
WriteShot = Callable[[int, "MeasuredShot"], object]
"""Adds a measured shot to a table under its number."""

MOST_DIGITS = 15
"""Of a whole number: so many are exact in double precision."""


def whole_number(text: str) -> bool:
    """Return whether a text is a whole number, 0 at least, of a size that everything can hold."""
    return text.isascii() and text.isdecimal() and len(text) <= MOST_DIGITS


def not_whole(text: str) -> str:
    """Return why a text is not a `whole_number`."""
    if text.isdecimal() and len(text) > MOST_DIGITS:
        return f"{text[:MOST_DIGITS]}... has {len(text)} digits, allowed are {MOST_DIGITS}"
    return f"{text!r} is not a whole number"


@dataclass(frozen=True, slots=True)
class TableRow:
    """One line of a CSV file: its fields by the names of their columns."""

    path: Path
    line: int
    fields: dict[str, str]

    def fault(self, reason: str) -> InputError:
        """Return what is to be raised about this line."""
        return InputError(self.path, reason, self.line)

    def number(self, name: str) -> float | None:
        """Return a number, None for an empty field or a column that is not there.

        Raises
        ------
        InputError
            It is no number, or not a finite one.
        """
        field = self.fields.get(name, "").strip()
        if not field:
            return None
        try:
            value = float(field)
        except ValueError as error:
            raise self.fault(f"{name}: {field!r} is not a number") from error
        if not math.isfinite(value):
            raise self.fault(f"{name}: {field!r} is not finite")
        return value

    def whole(self, name: str) -> int:
        """Return a whole number.

        Raises
        ------
        InputError
            It is none.
        """
        text = self.fields[name].strip()
        if not whole_number(text.removeprefix("-")):
            raise self.fault(f"{name}: {not_whole(text)}")
        return int(text)

    def sigma(self, name: str) -> float | None:
        """Return a standard error, None where it is not stated: an empty field, or zero.

        Raises
        ------
        InputError
            It is no number, or negative.
        """
        value = self.number(name)
        if value is not None and value < 0:
            raise self.fault(f"{name}: {value} is not a standard error, being negative")
        return value or None


def read_rows(path: Path, columns: Sequence[str], optional: Sequence[str] = ()) -> list[TableRow]:
    """Read a table whose columns are known by name and may stand in any order.

    Parameters
    ----------
    columns, optional
        Those that must be there, and those that may.

    Raises
    ------
    InputError
        Absent, not CSV in UTF-8, a column missing, unknown or twice, or a line of another length;
        with the line. More fields than `file_limits` allow to be held.
    """
    return list(held(path, each_row(path, columns, optional), lambda row: len(row.fields)))


def held(path: Path, rows: Iterable[Row], fields: Callable[[Row], int]) -> Iterator[Row]:
    """Yield rows that the caller keeps in memory; raise `InputError` where they are too many."""
    most, count = file_limits().table_fields, 0
    for row in rows:
        count += fields(row)
        if count > most:
            raise _too_large(path, f"{most} fields", "table_fields")
        yield row


def each_row(
    path: Path, columns: Sequence[str], optional: Sequence[str] = ()
) -> Iterator[TableRow]:
    """Read a table as `read_rows`, a row at a time; faults are raised where they are met."""
    lines = each_line(path)
    names = [name.strip() for name in next(lines, (0, []))[1]]
    given = [name for name in names if name not in optional]
    if sorted(given) != sorted(columns) or len(set(names)) != len(names):
        further = f", and may be {','.join(optional)}" if optional else ""
        raise InputError(path, f"the columns must be {','.join(columns)}{further}", 1)
    for line, (_, fields) in enumerate(lines, start=2):
        if not fields:
            continue
        if len(fields) != len(names):
            found = counted(len(fields), "field")
            raise InputError(path, f"{found} for {len(names)} columns", line)
        yield TableRow(path, line, dict(zip(names, fields, strict=True)))


def each_line(path: Path, *, strict: bool = False) -> Generator[tuple[int, list[str]], None, None]:
    """Read the fields of a CSV file, a line at a time, each with the number of its last line.

    Parameters
    ----------
    strict
        Whether a quote that is out of place is a fault.

    Raises
    ------
    InputError
        Absent, not CSV in UTF-8, or larger or with a longer line than `file_limits` allow.
    """
    limits = file_limits()
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            if path.stat().st_size > 1e6 * limits.table_mb:
                raise _too_large(path, f"{1e6 * limits.table_mb:.0f} bytes", "table_mb")
            reader = csv.reader(_lines(path, file, int(1e3 * limits.line_kb)), strict=strict)
            for fields in reader:
                yield reader.line_num, fields
    except FileNotFoundError as error:
        raise InputError(path, "no such file") from error
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(path, f"not CSV in UTF-8: {error}") from error


def _lines(path: Path, file: TextIO, most: int) -> Iterator[str]:
    while line := file.readline(most + 1):
        if len(line) > most:
            raise _too_large(path, f"{most} characters in a line", "line_kb")
        yield line


def _too_large(path: Path, limit: str, name: str) -> InputError:
    return InputError(
        path, f"has more than {limit}; split it, or raise files.{name} in the configuration"
    )


@contextmanager
def table_writer(path: Path, names: list[str]) -> Iterator[Writer]:
    """Give a CSV file with its heading written."""
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(names)
        yield table
