"""`rigctl sweep`: hand a sweep to the daemon, watch it, and steer it."""

from __future__ import annotations

import math
import time
import uuid
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, Protocol

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

from rigctl.cli.options import Config, Json, Key, KeyFile, given_key
from rigctl.cli.output import print_json
from rigctl.client import connected
from rigctl.config import load
from rigctl.config.loading import checked, read_toml
from rigctl.errors import ConfigurationError, NotFoundError, RefusedError, SettingsError
from rigctl.rig.bounds import require_value
from rigctl.sweeps.form import Sweep, read_sweep

Document = Mapping[str, Any]

Values = typer.Option(metavar="A:B:N", help="N values from A to B, or a list A,B,C; kPa.")
Name = Annotated[str | None, typer.Argument(metavar="[SWEEP]", help="Without it the latest.")]

_POLL_S = 0.3
_SHOT_S = 60.0
"""Longest wait of a pause or an abort for the end of the shot under way, s."""

_ENDED = frozenset({"completed", "aborted"})
_DONE = ("stored", "lost", "not_fired", "unknown")
"""States of the steps that have had their turn."""


class Steerable(Protocol):
    """A daemon that runs sweeps."""

    def start_sweep(self, form: Document, key: str) -> Document:
        """Start a sweep under this idempotency key and return it."""

    def sweeps(self) -> Document:
        """Return the list of sweeps, latest first."""

    def sweep(self, name: str) -> Document:
        """Return one sweep."""

    def sweep_steps(self, name: str) -> Document:
        """Return what was asked of a sweep (`form`) and its steps (`table`)."""

    def order_sweep(self, name: str, wish: str) -> Document:
        """Pause, resume or abort a sweep and return it."""


def run(
    file: Annotated[Path | None, typer.Argument(help="Sweep file (TOML).")] = None,
    *,
    pressure_kpa: Annotated[str | None, Values] = None,
    pressure_b_kpa: Annotated[
        str | None, typer.Option(metavar="A:B:N", help="Likewise of pusher b; as a without it.")
    ] = None,
    offset_mm: Annotated[
        str | None, typer.Option(metavar="A:B:N", help="Offset of tube b below a, likewise; mm.")
    ] = None,
    repeat: Annotated[int, typer.Option(min=1, max=1000, help="How often all is fired.")] = 1,
    shuffle: Annotated[
        bool, typer.Option(help="Fire in a drawn order, so that a drift is no effect of a setting.")
    ] = True,
    seed: Annotated[int, typer.Option(min=0, help="Draws the order.")] = 0,
    settle_s: Annotated[
        float, typer.Option(min=0.0, help="Wait between settings reached and fire, s.")
    ] = 0.0,
    pause_s: Annotated[float, typer.Option(min=0.0, help="Rest after each shot, s.")] = 0.0,
    until: Annotated[
        str | None,
        typer.Option(metavar="NAME=SIGMA", help="End once e or beta is known so well: e=0.001."),
    ] = None,
    adaptive: Annotated[
        bool, typer.Option("--adaptive", help="Fire where most is learned of what --until names.")
    ] = False,
    campaign: Annotated[str | None, typer.Option(help="Campaign the shots belong to.")] = None,
    detach: Annotated[bool, typer.Option("--detach", help="Do not watch it to its end.")] = False,
    config: Config = None,
    key: Key = None,
    key_file: KeyFile = None,
    json: Json = False,
) -> None:
    """Run what a file or ranges ask for; the sweep goes on when nobody watches it any more.

    Raises
    ------
    ConfigurationError, SettingsError
        The file cannot be; neither file nor ranges are given, or both; a range cannot be, or lies
        outside the rig's limits.
    RefusedError
        The daemon refused it, or it was paused or aborted before its end.
    """
    ranges = {
        name: (option, text)
        for name, option, text in (
            ("pressure_a_kpa", "--pressure-kpa", pressure_kpa),
            ("pressure_b_kpa", "--pressure-b-kpa", pressure_b_kpa),
            ("offset_mm", "--offset-mm", offset_mm),
        )
        if text is not None
    }
    order: dict[str, Any] = {
        "repeat": repeat,
        "shuffle": shuffle,
        "seed": seed,
        "settle_s": settle_s,
        "pause_s": pause_s,
        "campaign": campaign,
    }
    if until is not None:
        order["until"] = _until(until) | {"adaptive": adaptive}
    elif adaptive and file is None:
        raise SettingsError("has no aim", part="--adaptive", todo="say --until NAME=SIGMA")
    try:
        form = _of_ranges(ranges, order) if file is None else _of_file(file, ranges)
    except ConfigurationError:
        # Where a value is beyond any rig, this rig's own limits say what may be asked of it.
        asked = read_toml(file) if file and not ranges else {"grid": _grid(ranges)}
        _require_within(asked, config)
        raise
    with connected(config, given_key(key, key_file)) as daemon:
        document = form.model_dump(mode="json", exclude_defaults=True)
        started = daemon.start_sweep(document, str(uuid.uuid4()))
        for warning in started["warnings"]:
            typer.echo(f"rigctl: warning: {warning}", err=True)
        name = str(started["sweep"])
        if not detach:
            _watch(daemon, name)
        found = _show(daemon, name, as_json=json)
    if not detach and found["state"] != "completed":
        raise RefusedError(
            f"the sweep is {found['state']}: {found['reason']}",
            part=f"sweep {name}",
            todo="see it with rigctl sweep status",
        )


def status(
    name: Name = None,
    *,
    config: Config = None,
    key: Key = None,
    key_file: KeyFile = None,
    json: Json = False,
) -> None:
    """Print one sweep, or the latest; raise `NotFoundError` where there is none."""
    with connected(config, given_key(key, key_file)) as daemon:
        _show(daemon, name or _latest(daemon), as_json=json)


def _steering(wish: str) -> Callable[..., None]:
    """Return the command that pauses, resumes or aborts a sweep; raise as `_order`."""

    def steer(
        name: Name = None,
        *,
        config: Config = None,
        key: Key = None,
        key_file: KeyFile = None,
        json: Json = False,
    ) -> None:
        with connected(config, given_key(key, key_file)) as daemon:
            _order(daemon, wish, name, as_json=json)

    return steer


pause, resume, abort = (_steering(wish) for wish in ("pause", "resume", "abort"))


def _order(daemon: Steerable, wish: str, name: str | None, *, as_json: bool) -> None:
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
    deadline = time.monotonic() + _SHOT_S
    found = daemon.order_sweep(name, wish)
    while found["asked"] is not None and time.monotonic() < deadline:
        time.sleep(_POLL_S)
        found = daemon.sweep(name)
    _show(daemon, name, as_json=as_json)


def _of_file(file: Path, ranges: Document) -> Sweep:
    if ranges:
        raise ConfigurationError(
            "a sweep is given by a file or by ranges, not by both",
            part=str(file),
            todo="leave one of them out",
        )
    return read_sweep(file)


def _of_ranges(ranges: Mapping[str, tuple[str, str]], order: Document) -> Sweep:
    if not {"pressure_a_kpa", "offset_mm"} <= ranges.keys():
        raise ConfigurationError(
            "a sweep needs a file, or --pressure-kpa and --offset-mm", todo="give one of them"
        )
    grid = _grid(ranges)
    document = {name: value for name, value in order.items() if value is not None}
    return checked(Sweep, {**document, "grid": grid}, "rigctl sweep")


def _grid(ranges: Mapping[str, tuple[str, str]]) -> Document:
    return {name: _levels(*given) for name, given in ranges.items()}


def _require_within(asked: Document, config: Path | None) -> None:
    """Check the levels of a grid and the values of listed shots against this rig's limits.

    What is no grid and no shot has none; nor has a rig whose configuration cannot be read.

    Raises
    ------
    SettingsError
        A value lies outside; those between the ends of a range lie within where the ends do.
    """
    try:
        limits = load(config).limits
    except ConfigurationError:
        return
    shots = asked.get("shots")
    tables = [asked.get("grid"), *(shots if isinstance(shots, list) else [])]
    levels = (pair for table in tables if isinstance(table, dict) for pair in table.items())
    for name, own in levels:
        ends = [own.get("first"), own.get("last")] if isinstance(own, dict) else own
        for value in ends if isinstance(ends, list) else [ends]:
            if isinstance(value, (int, float)) and math.isfinite(value):
                require_value(name, float(value), limits)


def _levels(option: str, text: str) -> list[float] | Document:
    """Return the values that `A:B:N`, `A,B,C` or `A` stands for."""
    try:
        if ":" not in text:
            return [float(part) for part in text.split(",")]
        first, last, count = text.split(":")
        if int(count) == 1 and float(first) == float(last):
            return [float(first)]
        return {"first": float(first), "last": float(last), "count": int(count)}
    except ValueError as error:
        raise SettingsError(
            "is neither a range nor a list of numbers",
            part=option,
            value=repr(text),
            limit="A:B:N (N values from A to B), or A,B,C",
            todo="write it so",
        ) from error


def _until(text: str) -> dict[str, Any]:
    name, _, sigma = text.partition("=")
    try:
        return {"coefficient": name, "sigma": float(sigma)}
    except ValueError as error:
        raise SettingsError(
            "names no standard error",
            part="--until",
            value=repr(text),
            limit="NAME=SIGMA, such as e=0.001",
            todo="write it so",
        ) from error


def _latest(daemon: Steerable, *, live: bool = False) -> str:
    for each in daemon.sweeps()["sweeps"]:
        if not live or each["state"] not in _ENDED:
            return str(each["sweep"])
    raise NotFoundError("there is no such sweep", todo="start one with rigctl sweep FILE")


def _watch(daemon: Steerable, name: str) -> None:
    with _bar() as show:
        try:
            while True:
                found = daemon.sweep(name)
                show(found)
                if found["state"] != "running":
                    return
                time.sleep(_POLL_S)
        except KeyboardInterrupt:
            todo = f"it goes on; rigctl sweep pause {name}, or abort"
            raise RefusedError("nobody watches it", part=f"sweep {name}", todo=todo) from None


@contextmanager
def _bar() -> Iterator[Callable[[Document], None]]:
    """Give a function that shows how far a sweep is, on standard error, if a person watches."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda _: None
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, TextColumn("{task.fields[left]}"), console=console) as progress:
        bar = progress.add_task("", total=None, left="")

        def show(found: Document) -> None:
            progress.update(
                bar,
                description=f"sweep {found['sweep']}",
                total=found["steps"],
                completed=_done(found),
                left=_left(found),
            )

        yield show


def _done(found: Document) -> int:
    return sum(int(found["counts"][state]) for state in _DONE)


def _left(found: Document) -> str:
    seconds = found["left_s"]
    if seconds is None:
        return ""
    minutes, rest = divmod(round(seconds), 60)
    return f"about {minutes} min {rest:02d} s left" if minutes else f"about {rest} s left"


def _show(daemon: Steerable, name: str, *, as_json: bool) -> Document:
    found = {**daemon.sweep(name), **daemon.sweep_steps(name)}
    console = Console(highlight=False, soft_wrap=True)
    if as_json:
        print_json(found, indent=1)
    else:
        _print(console, found)
    return found


def _print(console: Console, found: Document) -> None:
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
