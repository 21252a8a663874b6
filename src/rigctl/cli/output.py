"""What commands print: progress for a person who watches, one JSON document, lines and tables."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, TextColumn
from rich.progress import Progress as Bar
from rich.table import Table

from rigctl.progress import Progress

Json = Mapping[str, Any]

TABLE_WIDTH = 110
"""A narrower terminal wraps the rows; cut digits would be wrong numbers."""


@contextmanager
def progress() -> Iterator[Callable[[str], None]]:
    """Give a function that shows what is being done, on standard error, if a person watches."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda _: None
        return
    with console.status("") as status:
        yield lambda text: status.update(f"{text} ...")


@contextmanager
def bar() -> Iterator[Progress]:
    """Give a function that shows a step in words and the part done, from 0 to 1.

    It writes to standard error, and only to a terminal.
    """
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda _text, _share: None
        return
    columns = (TextColumn("{task.description}"), BarColumn())
    with Bar(*columns, console=console, transient=True) as shown:
        task = shown.add_task("", total=1.0)
        yield lambda text, share: shown.update(task, description=text, completed=share or 0.0)


def print_json(document: Json | Sequence[Json], indent: int | None = None) -> None:
    """Print one document on standard output."""
    sys.stdout.write(json.dumps(document, allow_nan=False, indent=indent) + "\n")


def print_line(text: str) -> None:
    """Print a line as it is, however long."""
    Console(highlight=False, soft_wrap=True, markup=False).print(text)


def plain_table(left: Sequence[str], right: Sequence[str] = (), *, title: str = "") -> Table:
    """Return a table without lines: columns set to the left, then columns of numbers."""
    table = Table(title=title or None, title_justify="left", box=None)
    for heading in left:
        table.add_column(heading)
    for heading in right:
        table.add_column(heading, justify="right")
    return table


def unit_word(unit: str) -> str:
    """Return a unit as it is printed: nothing for a pure number."""
    return "" if unit == "1" else unit
