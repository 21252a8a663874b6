"""`rigctl shot`: arm, fire once, wait for the measurement, print it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from pydantic import ValidationError
from rich.console import Console
from rich.table import Table

from rigctl.cli.options import Config, Json, Key, KeyFile, given_key
from rigctl.cli.output import print_json, progress
from rigctl.client import connected
from rigctl.config import load
from rigctl.errors import NotFoundError, RefusedError, SettingsError
from rigctl.firing import ON_THE_WAY, fire_and_wait
from rigctl.plain_text import require_word
from rigctl.rig.bounds import allowed, require_value
from rigctl.settings import ShotSettings

if TYPE_CHECKING:
    from rigctl.local import LocalRig

_WITHOUT_FRAMES = frozenset({"misfire", "aborted", "unknown_outcome", "interrupted"})
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


def shot(
    *,
    pressure_kpa: Annotated[float, typer.Option(help="Gauge pressure of pusher a in kPa.")],
    offset_mm: Annotated[float, typer.Option(help="Vertical offset of tube b below a in mm.")],
    pressure_b_kpa: Annotated[
        float | None, typer.Option(help="Gauge pressure of pusher b in kPa; as a without it.")
    ] = None,
    delay_us: Annotated[
        float, typer.Option(help="Pusher b fires this much later, microseconds.")
    ] = 0.0,
    angle_a_deg: Annotated[
        float | None, typer.Option(help="Tilt of tube a in degrees; release apparatus only.")
    ] = None,
    angle_b_deg: Annotated[
        float | None, typer.Option(help="Tilt of tube b in degrees; release apparatus only.")
    ] = None,
    campaign: Annotated[str | None, typer.Option(help="Campaign the shot belongs to.")] = None,
    local: Annotated[bool, typer.Option("--local", help="Fire without a daemon.")] = False,
    wait_s: Annotated[
        float, typer.Option(min=0.0, max=3600.0, help="Longest wait for the measurement, s.")
    ] = 120.0,
    config: Config = None,
    key: Key = None,
    key_file: KeyFile = None,
    json: Json = False,
) -> None:
    """Fire one shot and print what was measured.

    Raises
    ------
    SettingsError
        A setting lies beyond the bounds of physics, or the campaign's name could not be a
        folder's: found before any rig is armed.
    RefusedError
        The rig refused, or the shot did not come through.
    NotFoundError
        The shot was fired, and there is no measurement of it.
    """
    settings = settings_of(
        config,
        pressure_a_kpa=pressure_kpa,
        pressure_b_kpa=pressure_kpa if pressure_b_kpa is None else pressure_b_kpa,
        offset_mm=offset_mm,
        delay_us=delay_us,
        angle_a_deg=angle_a_deg,
        angle_b_deg=angle_b_deg,
    )
    if campaign is not None:
        require_word(campaign, "is not a campaign's name", "campaign", todo="choose another name")
    if local:
        with _local(config) as mine, progress() as report:
            document = fire_and_wait(
                mine, settings, campaign, wait_s, report, warn=_warn, compiling=mine.compiling
            )
    else:
        with connected(config, given_key(key, key_file)) as rig, progress() as report:
            document = fire_and_wait(rig, settings, campaign, wait_s, report, warn=_warn)
    _print(document, as_json=json)
    _require_measured(document, local=local)


def _local(config: Path | None) -> AbstractContextManager[LocalRig]:
    # A daemon loads what a command beside one does not need.
    from rigctl import logs  # noqa: PLC0415
    from rigctl.cli.frames.compile_note import announce_compiling  # noqa: PLC0415
    from rigctl.local import opened  # noqa: PLC0415

    logs.set_up("text")
    announce_compiling(load(config).analysis.method)
    return opened(config)


def _warn(text: str) -> None:
    typer.echo(f"rigctl: warning: {text}", err=True)


def settings_of(config: Path | None, **fields: float | None) -> ShotSettings:
    """Return checked settings; a field that is None is left out.

    Raises
    ------
    SettingsError
        A value is not a finite number within the bounds of physics; the rig's own limits are named.
    ConfigurationError
        The configuration, which states them, cannot be.
    """
    given = {name: value for name, value in fields.items() if value is not None}
    try:
        return ShotSettings.model_validate(given)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        name = str(first["loc"][0])
        limits = load(config).limits
        # The bounds of physics are wider: they would name a limit that is none of this rig's.
        if first["type"] in {"greater_than_equal", "less_than_equal"}:
            require_value(name, float(first["input"]), limits)
        raise SettingsError(
            first["msg"][0].lower() + first["msg"][1:],
            part=name,
            value=str(first["input"]),
            limit=allowed(name, limits),
            todo="choose another value",
        ) from error


def _print(document: Mapping[str, Any], *, as_json: bool) -> None:
    if as_json:
        print_json(document, indent=1)
        return
    console = Console()
    settings = document["settings"]
    console.print(
        f"shot {document['shot']}, {document['state']}: {settings['pressure_a_kpa']:g} and "
        f"{settings['pressure_b_kpa']:g} kPa, offset {settings['offset_mm']:g} mm"
        + (", simulated" if document["simulated"] else ""),
        highlight=False,
    )
    result = document["result"] or {}
    if result.get("impacts") == []:
        seen = len(result["positions"]["frame"])
        console.print(
            f"no bounce: a flight in {seen} frames. `rigctl qualify drop --config FILE` takes "
            "gravity from several.",
            highlight=False,
        )
    for impact in result.get("impacts", [result]):
        if rows := _told(impact):
            if "impacts" in result:
                console.print(f"impact at {impact['contact_time_s']:.4f} s", highlight=False)
            console.print(_table(rows))


def _told(impact: Mapping[str, Any]) -> list[tuple[str, Mapping[str, Any]]]:
    """Return the quantities with a value; what cannot be known without spin has none."""
    found = [(name, impact.get(name)) for name in _NAMES]
    return [(name, own) for name, own in found if own and own.get("value") is not None]


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
        # An error without bound is null.
        sigma = math.inf if quantity["sigma"] is None else float(quantity["sigma"])
        found = factor * float(quantity["value"])
        table.add_row(_NAMES[name], *rounded(found, factor * sigma), unit)
    return table


def _require_measured(document: Mapping[str, Any], *, local: bool) -> None:
    state, name = str(document["state"]), str(document["shot"])
    why = f": {document['failure']}" if document["failure"] else ""
    if state in _WITHOUT_FRAMES:
        raise RefusedError(
            f"the shot ended as {state.replace('_', ' ')}{why}",
            shot=name,
            todo="look at the rig before the next one",
        )
    if state == "refused":
        raise NotFoundError(
            f"the frames are stored, but the analysis refused them{why}",
            shot=name,
            todo="look at the frames",
        )
    if state in ON_THE_WAY:
        later = (
            "its frames are stored: the next `rigctl shot --local` or `rigctl serve` on this store "
            "measures it; give a longer --wait-s, and compile beforehand with `rigctl precompile`"
            if local
            else f"ask later with GET /api/v1/shots/{name}/result; the first analysis on the "
            "daemon's computer takes minutes, `rigctl precompile` there does that beforehand"
        )
        raise NotFoundError(
            f"the shot is {state}, its measurement did not come in time", shot=name, todo=later
        )
