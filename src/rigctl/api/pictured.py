"""Results that a notebook shows as a table, and that draw themselves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING

from rigctl.api.columns import Array, Columns, as_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from pandas import DataFrame


class Pictured:
    """A result with a headline, a table and a picture."""

    def table(self) -> DataFrame | Columns:
        """Return the result as a table: a DataFrame where pandas is installed, else columns."""
        return as_table(self._columns(), {})

    def plot(self) -> Axes:
        """Draw the result; return the first axes of the figure, whose `figure.axes` has all."""
        raise NotImplementedError

    def __str__(self) -> str:
        """Return headline and table as text."""
        return f"{self._headline()}\n{self._whole()}"

    __repr__ = __str__

    def _repr_html_(self) -> str:
        head = escape(self._headline()).replace("\n", "<br>")
        return f"<p>{head}</p>{self._whole().to_html()}"

    def _headline(self) -> str:
        raise NotImplementedError

    def _columns(self) -> Mapping[str, Sequence[object] | Array]:
        raise NotImplementedError

    def _whole(self) -> Columns:
        return Columns.of(self._columns())
