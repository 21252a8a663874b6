"""How far a command is, as long as a person watches."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

Say = Callable[[str, float | None], None]


@contextmanager
def bar() -> Iterator[Say]:
    """Give a function that shows a step in words and the part done, from 0 to 1.

    It writes to standard error, and only to a terminal.
    """
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda _text, _share: None
        return
    columns = (TextColumn("{task.description}"), BarColumn())
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task("", total=1.0)
        yield lambda text, share: progress.update(task, description=text, completed=share or 0.0)
