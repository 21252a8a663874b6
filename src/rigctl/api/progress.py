"""How far a measurement is, as long as a person watches: in a terminal or in a notebook."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import Progress

Counter = Callable[[int, int], None]


@contextmanager
def counting(what: str) -> Iterator[Counter]:
    """Yield a function to call with the number done and the total number."""
    console = Console(stderr=True)
    if console.is_jupyter:
        yield lambda done, total: _line(f"{what}: {done} of {total}")
        _line("\n")
        return
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(what, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


@contextmanager
def stating() -> Iterator[Callable[[str], None]]:
    """Give a function that shows what is being done."""
    console = Console(stderr=True)
    if not console.is_terminal or console.is_jupyter:
        yield lambda _text: None
        return
    with console.status("") as status:
        yield lambda text: status.update(f"{text} ...")


def _line(text: str) -> None:
    sys.stderr.write(f"\r{text}")
    sys.stderr.flush()
