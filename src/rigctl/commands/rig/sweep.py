"""`rigctl sweep`: hand a sweep to the daemon, watch it, and steer it."""

from __future__ import annotations

import json
import time
import uuid
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any, Protocol

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

from rigctl.access.strength import Chosen
from rigctl.commands.client import connected
from rigctl.errors import NotFoundError, RefusedError
from rigctl.sweeps.form import Sweep

Json = Mapping[str, Any]

_POLL_S = 0.3
_SHOT_S = 60.0
"""Longest wait of a pause or an abort for the end of the shot under way, s."""

_ENDED = frozenset({"completed", "aborted"})
_DONE = ("stored", "lost", "not_fired", "unknown")
"""States of the steps that have had their turn."""


class Steerable(Protocol):
    """A daemon that runs sweeps."""

    def start_sweep(self, form: Json, key: str) -> Json:
        """Start a sweep under this idempotency key and return it."""

    def sweeps(self) -> Json:
        """Return the list of sweeps, latest first."""

    def sweep(self, name: str) -> Json:
        """Return one sweep."""

    def sweep_steps(self, name: str) -> Json:
        """Return what was asked of a sweep (`form`) and its steps (`table`)."""

    def order_sweep(self, name: str, wish: str) -> Json:
        """Pause, resume or abort a sweep and return it."""


def service(path: Path | None, key: Chosen | None) -> AbstractContextManager[Steerable]:
    """Give the daemon that runs on a configuration's store; as `client.connected`."""
    return connected(path, key)


def run(
    daemon: Steerable,
    form: Sweep,
    *,
    watch: bool,
    as_json: bool,
    rest: Callable[[float], None] = time.sleep,
) -> None:
    """Start a sweep; watch it until it ends or waits for a person, then print it.

    Whoever stops watching leaves the sweep running.

    Raises
    ------
    RefusedError
        The daemon refused it, or it was paused or aborted before its end.
    """
    document = form.model_dump(mode="json", exclude_defaults=True)
    name = str(daemon.start_sweep(document, str(uuid.uuid4()))["sweep"])
    if watch:
        _watch(daemon, name, rest)
    found = _show(daemon, name, as_json=as_json)
    if watch and found["state"] != "completed":
        raise RefusedError(
            f"the sweep is {found['state']}: {found['reason']}",
            part=f"sweep {name}",
            todo="see it with rigctl sweep status",
        )


def show(daemon: Steerable, name: str | None, *, as_json: bool) -> None:
    """Print one sweep, or the latest; raise `NotFoundError` where there is none."""
    _show(daemon, name or _latest(daemon), as_json=as_json)


def order(
    daemon: Steerable,
    wish: str,
    name: str | None,
    *,
    as_json: bool,
    rest: Callable[[float], None] = time.sleep,
    clock: Callable[[], float] = time.monotonic,
) -> None:
    """Pause, resume or abort a sweep, or the latest that has not ended; print it as it stands.

    A pause and an abort wait for the end of the shot under way, at most a minute.

    Raises
    ------
    NotFoundError
        There is none.
    RefusedError
        It cannot be done now.
    """
    name = name or _latest(daemon, live=True)
    deadline = clock() + _SHOT_S
    found = daemon.order_sweep(name, wish)
    while found["asked"] is not None and clock() < deadline:
        rest(_POLL_S)
        found = daemon.sweep(name)
    _show(daemon, name, as_json=as_json)


def _latest(daemon: Steerable, *, live: bool = False) -> str:
    for each in daemon.sweeps()["sweeps"]:
        if not live or each["state"] not in _ENDED:
            return str(each["sweep"])
    raise NotFoundError("there is no such sweep", todo="start one with rigctl sweep FILE")


def _watch(daemon: Steerable, name: str, rest: Callable[[float], None]) -> None:
    with _bar() as tell:
        try:
            while True:
                found = daemon.sweep(name)
                tell(found)
                if found["state"] != "running":
                    return
                rest(_POLL_S)
        except KeyboardInterrupt:
            todo = f"it goes on; rigctl sweep pause {name}, or abort"
            raise RefusedError("nobody watches it", part=f"sweep {name}", todo=todo) from None


@contextmanager
def _bar() -> Iterator[Callable[[Json], None]]:
    """Give a function that shows how far a sweep is, on standard error, if a person watches."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda _: None
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, TextColumn("{task.fields[left]}"), console=console) as progress:
        bar = progress.add_task("", total=None, left="")

        def tell(found: Json) -> None:
            progress.update(
                bar,
                description=f"sweep {found['sweep']}",
                total=found["steps"],
                completed=_done(found),
                left=_left(found),
            )

        yield tell


def _done(found: Json) -> int:
    return sum(int(found["counts"][state]) for state in _DONE)


def _left(found: Json) -> str:
    seconds = found["left_s"]
    if seconds is None:
        return ""
    minutes, rest = divmod(round(seconds), 60)
    return f"about {minutes} min {rest:02d} s left" if minutes else f"about {rest} s left"


def _show(daemon: Steerable, name: str, *, as_json: bool) -> Json:
    found = {**daemon.sweep(name), **daemon.sweep_steps(name)}
    console = Console(highlight=False, soft_wrap=True)
    if as_json:
        console.file.write(json.dumps(found, indent=1, allow_nan=False) + "\n")
    else:
        _print(console, found)
    return found


def _print(console: Console, found: Json) -> None:
    asked = f" ({found['asked']} asked)" if found["asked"] else ""
    console.print(f"sweep {found['sweep']}: {found['state']}{asked}; {found['reason']}")
    counts = [f"{n} {state.replace('_', ' ')}" for state, n in found["counts"].items() if n]
    console.print(f"{_done(found)} of {found['steps']} steps: {', '.join(counts)}")
    if left := _left(found):
        console.print(left)
    mean = found["mean"]
    if mean is not None and mean["sigma"] is not None:
        console.print(
            f"{mean['coefficient']} = {mean['value']:.5f} ± {mean['sigma']:.2g}, "
            f"{mean['shots']} shots"
        )
    for step in found["table"]:
        if step["failure"]:
            console.print(f"step {step['step']} (shot {step['shot'] or '-'}): {step['failure']}")
