"""Rows of a table of numbers, each of which can say where it stands and what is wrong with it."""

from __future__ import annotations

import csv
import math
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from analysis.errors import InputError, counted


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
        try:
            return int(self.fields[name])
        except ValueError as error:
            raise self.fault(f"{name}: {self.fields[name]!r} is not a whole number") from error

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
        with the line.
    """
    return list(each_row(path, columns, optional))


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
        Absent, or not CSV in UTF-8.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.reader(file, strict=strict)
            for fields in reader:
                yield reader.line_num, fields
    except FileNotFoundError as error:
        raise InputError(path, "no such file") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(path, f"not CSV in UTF-8: {error}") from error
