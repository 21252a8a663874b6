"""What a person sees of a shot: progress while it runs, a table when it is measured."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from rich.console import Console
from rich.table import Table

_NAMES = {
    "v_n": "normal velocity before",
    "v_s": "surface velocity before",
    "v_n_after": "normal velocity after",
    "v_s_after": "surface velocity after",
    "e": "restitution e",
    "beta": "tangential restitution β",
    "contact_duration": "duration of contact",
}
_SHOWN_IN = {"s": (1e6, "µs"), "1": (1.0, "")}
"""Factor and unit in which the table shows what results hold in SI units."""


@contextmanager
def progress() -> Iterator[Callable[[str], None]]:
    """Give a function that shows what is being done, on standard error, if a person watches."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda _: None
        return
    with console.status("") as status:
        yield lambda text: status.update(f"{text} ...")


def show_shot(document: Mapping[str, Any], *, as_json: bool) -> None:
    """Print a shot with its measurement on standard output, as a table or as one JSON document."""
    console = Console()
    if as_json:
        console.file.write(json.dumps(document, indent=1, allow_nan=False) + "\n")
        return
    settings = document["settings"]
    console.print(
        f"shot {document['shot']}, {document['state']}: {settings['pressure_a_kpa']:g} and "
        f"{settings['pressure_b_kpa']:g} kPa, offset {settings['offset_mm']:g} mm"
        + (", simulated" if document["simulated"] else ""),
        highlight=False,
    )
    result = document["result"] or {}
    rows = [(name, result[name]) for name in _NAMES if isinstance(result.get(name), dict)]
    if rows:
        console.print(_table(rows))


def rounded(value: float, sigma: float) -> tuple[str, str]:
    """Return value and standard error as text, both to the error's second significant digit.

    An error that is zero or not finite says nothing about digits: six are given then.
    """
    if not (math.isfinite(value) and math.isfinite(sigma) and sigma > 0):
        return f"{value:.6g}", f"{sigma:.2g}"
    digits = max(0, 1 - math.floor(math.log10(sigma)))
    return f"{value:.{digits}f}", f"{sigma:.{digits}f}"


def _table(rows: list[tuple[str, Mapping[str, Any]]]) -> Table:
    table = Table("quantity", "value", "± σ", "unit", box=None, pad_edge=False)
    for column in table.columns[1:3]:
        column.justify = "right"
    for name, quantity in rows:
        factor, unit = _SHOWN_IN.get(quantity["unit"], (1.0, str(quantity["unit"])))
        found, error = factor * float(quantity["value"]), factor * float(quantity["sigma"])
        table.add_row(_NAMES[name], *rounded(found, error), unit)
    return table
