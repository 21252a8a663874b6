"""What tables of one line a shot have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from analysis.exchange.rows import TableRow


@dataclass(frozen=True, slots=True)
class Tabulated:
    """One line of such a table, by the number of its shot."""

    shot: int


def require_once(rows: Sequence[TableRow], found: Sequence[Tabulated]) -> None:
    """Require every shot to stand in one line only.

    Raises
    ------
    InputError
        One stands twice; with the line.
    """
    seen: set[int] = set()
    for row, one in zip(rows, found, strict=True):
        if one.shot in seen:
            raise row.fault(f"shot {one.shot} stands twice")
        seen.add(one.shot)


def require_errors_alike(rows: Sequence[TableRow], missing: Sequence[Sequence[str]]) -> None:
    """Require standard errors to be stated everywhere or nowhere.

    What is not stated is estimated as a scale for each channel, which a mixture would belie.

    Parameters
    ----------
    missing
        Of each line, the columns whose field is needed and empty or zero.

    Raises
    ------
    InputError
        A table states some and not others; with the first such line.
    """
    if all(map(_none_of_them, rows)):
        return
    for row, names in zip(rows, missing, strict=True):
        if names:
            raise row.fault(
                f"{names[0]}: not stated, where other errors are; state all of them, or none and "
                "have them estimated"
            )


def _none_of_them(row: TableRow) -> bool:
    return all(row.sigma(name) is None for name in row.fields if name.startswith("sigma_"))
