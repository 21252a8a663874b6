"""Filters of tables: words that stand anywhere in a row, and numbers of one column compared."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

Row = Mapping[str, object]
Test = Callable[[Row], bool]
COMPARED: dict[str, Callable[[Any, Any], bool]] = {
    "<=": operator.le,
    ">=": operator.ge,
    "!=": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
    "=": operator.eq,
}
CLAUSE = re.compile(
    r"\s*(?P<column>[^<>=!]*?)\s*(?P<sign><=|>=|!=|<|>|=)\s*(?P<value>[^<>=!]+?)\s*"
)
HINT = "a word, or offset > 10, e < 0.7"


class FilterError(ValueError):
    """What was typed compares something that cannot be compared; the message names it."""


@dataclass(frozen=True, slots=True)
class Filter:
    """The clauses of a filter, of which a row must pass all."""

    tests: tuple[Test, ...]

    @classmethod
    def of(cls, text: str, columns: Mapping[str, str]) -> Filter:
        """Return what a text asks for; its clauses are apart by commas or by `and`.

        Parameters
        ----------
        columns
            Label of each column by the key under which rows hold it. A clause may name either, or
            a beginning that only one has; units may be left out.

        Raises
        ------
        FilterError
            No column has that name, or several have, or a number is missing.
        """
        clauses = (part for part in re.split(r",|\band\b", text.lower()) if part.strip())
        return cls(tuple(_test(clause, columns) for clause in clauses))

    def keeps(self, row: Row) -> bool:
        """Say whether a row passes."""
        return all(test(row) for test in self.tests)


def _test(clause: str, columns: Mapping[str, str]) -> Test:
    found = CLAUSE.fullmatch(clause)
    if found is None:
        if re.search("[<>=]", clause):
            raise FilterError(f"“{clause.strip()}” compares nothing; write {HINT}")
        word = clause.strip()
        return lambda row: any(word in str(row.get(key, "")).lower() for key in columns)
    key = _column(found["column"], columns)
    compare = COMPARED[found["sign"]]
    try:
        limit = float(found["value"].replace("−", "-"))
    except ValueError:
        return _of_words(key, found["sign"], found["value"])

    def test(row: Row) -> bool:
        value = row.get(key)
        return isinstance(value, (int, float)) and compare(value, limit)

    return test


def _of_words(key: str, sign: str, value: str) -> Test:
    if sign not in {"=", "!="}:
        raise FilterError(f"“{value}” is no number; write {HINT}")
    return lambda row: (str(row.get(key, "")).lower() == value) == (sign == "=")


def _column(name: str, columns: Mapping[str, str]) -> str:
    wanted = _plain(name)
    names = {key: {_plain(key), _plain(label.partition(",")[0])} for key, label in columns.items()}
    exact = [key for key, own in names.items() if wanted in own]
    begun = exact or [k for k, own in names.items() if any(n.startswith(wanted) for n in own)]
    if len(begun) == 1 and wanted:
        return begun[0]
    said = "names several columns" if begun and wanted else "names no column"
    listed: Sequence[str] = [columns[key].partition(",")[0] for key in (begun or columns)]
    raise FilterError(f"“{name.strip()}” {said}: {', '.join(listed)}")


def _plain(name: str) -> str:
    return re.sub(r"[\s_]+", " ", name.lower().replace("\u00a0", " ")).strip()
