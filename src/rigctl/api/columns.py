"""Tables for those who have pandas, and for those who have not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from importlib.util import find_spec
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.generic]
UNITS = "units"
"""Key of a DataFrame's `attrs` with the unit of each column that has one."""
SHOWN = 60
"""Rows of a table as text or in a notebook."""


class Columns(dict[str, Array]):
    """A table by the names of its columns, all of one length; `units` are those of its columns."""

    def __init__(self, columns: Mapping[str, Array], units: Mapping[str, str]) -> None:
        super().__init__(columns)
        self.units = dict(units)

    @classmethod
    def of(
        cls,
        columns: Mapping[str, Sequence[object] | Array],
        units: Mapping[str, str] | None = None,
    ) -> Self:
        """Return columns of any values."""
        arrays = {name: np.asarray(values) for name, values in columns.items()}
        return cls(arrays, units or {})

    def rows(self) -> list[tuple[object, ...]]:
        """Return the rows."""
        return list(zip(*(column.tolist() for column in self.values()), strict=True))

    def __str__(self) -> str:
        """Return the table as text."""
        lines = [tuple(self), *(tuple(map(_text, row)) for row in self.rows()[:SHOWN])]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        return "\n".join(
            "  ".join(cell.rjust(wide) for cell, wide in zip(line, widths, strict=True))
            for line in lines
        )

    __repr__ = __str__

    def to_html(self) -> str:
        """Return the table as HTML, as a DataFrame's method of this name does."""
        head = "".join(f"<th>{escape(name)}</th>" for name in self)
        body = "".join(
            "<tr>" + "".join(f"<td>{escape(_text(cell))}</td>" for cell in row) + "</tr>"
            for row in self.rows()[:SHOWN]
        )
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"

    def _repr_html_(self) -> str:
        return self.to_html()


def as_table(
    columns: Mapping[str, Sequence[object] | Array], units: Mapping[str, str]
) -> DataFrame | Columns:
    """Return columns as a DataFrame where pandas is installed, else as `Columns`.

    Parameters
    ----------
    units
        Of the columns that have one; they are in `attrs["units"]` of a DataFrame.
    """
    whole = Columns.of(columns, units)
    if find_spec("pandas") is None:
        return whole
    import pandas as pd  # noqa: PLC0415 - an extra, and slow to load

    frame = pd.DataFrame(dict(whole))
    frame.attrs[UNITS] = dict(units)
    return frame


def _text(cell: object) -> str:
    if isinstance(cell, float):
        return f"{cell:.5g}"
    return str(cell)
