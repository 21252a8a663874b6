"""`rigctl calibrate`: estimates of the camera beside their errors and effects."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from analysis.calibration.calibrate import Calibration
from analysis.calibration.calibrate import calibrate as estimated
from analysis.calibration.estimate import Estimate
from analysis.campaign import read_campaign
from analysis.errors import InputError
from analysis.quantity import Quantity
from rigctl.cli.frames.calibrate_lens import board_of, calibrate_by_board
from rigctl.cli.frames.compile_note import announce_compiling
from rigctl.cli.options import Json
from rigctl.cli.output import TABLE_WIDTH, print_json
from rigctl.errors import AnalysisInputError, SettingsError


def calibrate(
    campaign: Annotated[
        Path, typer.Argument(help="Campaign folder with frames; with --board a film or pictures.")
    ],
    *,
    board: Annotated[
        str | None,
        typer.Option(help="A filmed chessboard in place of shots: its inner corners, as in 9x6."),
    ] = None,
    square_mm: Annotated[
        float | None, typer.Option(min=0.01, max=1e4, help="Side of a square of the board.")
    ] = None,
    marker_mm: Annotated[
        float | None,
        typer.Option(min=0.01, max=1e4, help="A ChArUco board: the side of its markers."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="With --board: write lens.toml, for analyse --lens.")
    ] = None,
    json: Json = False,
) -> None:
    """Estimate the camera of a campaign and print a table or one JSON document.

    Raises
    ------
    AnalysisInputError
        The campaign or the film cannot be read, no shot of it can be used, or it does not show the
        board.
    SettingsError
        An option is no board, or belongs to one that is not stated.
    """
    if board is not None:
        calibrate_by_board(campaign, board_of(board, square_mm, marker_mm), out, as_json=json)
        return
    for name, value in {"--square-mm": square_mm, "--marker-mm": marker_mm, "--out": out}.items():
        if value is not None:
            raise SettingsError(
                "is of a filmed board",
                part=name,
                value=str(value),
                todo="state the board too, as in --board 9x6, or leave it out",
            )
    announce_compiling("photometric")
    try:
        read = read_campaign(campaign)
        console = Console(stderr=True)
        with Progress(console=console, transient=True, disable=not sys.stderr.isatty()) as bar:
            task = bar.add_task("calibrating", total=len(read.jobs))
            result = estimated(read, lambda count, _: bar.update(task, completed=count))
    except InputError as error:
        part = error.path if error.line is None else f"{error.path}, line {error.line}"
        raise AnalysisInputError(error.reason, part=part) from error
    if json:
        print_json(_document(read.name, result))
        return
    Console(width=max(TABLE_WIDTH, Console().width)).print(_table(read.name, result))
    for shot, reason in result.refused.items():
        print(f"shot {shot} left out at {reason}")  # noqa: T201


def _document(name: str, result: Calibration) -> dict[str, object]:
    return {
        "campaign": name,
        "used": list(result.used),
        "refused": [{"shot": shot, "reason": why} for shot, why in result.refused.items()],
        "estimates": [
            {
                "name": one.name,
                "value": one.value if one.finite else None,
                "sigma": one.sigma if one.finite else None,
                "unit": one.unit,
                "determined": one.determined,
                "found": one.found,
                "effect": one.effect,
                "in_poses": one.in_poses,
                "how": one.how,
            }
            for one in result.estimates
        ],
    }


def _table(name: str, result: Calibration) -> Table:
    table = Table(
        title=f"{name}: the camera by {len(result.used)} shots", title_justify="left", box=None
    )
    for heading in ("estimate", "value", "unit", "the shots", "effect", "in the poses"):
        table.add_column(heading, no_wrap=True)
    for one in result.estimates:
        value = Quantity(one.value, one.sigma, one.unit).concise() if one.finite else "-"
        carried = "yes" if one.in_poses else "no"
        table.add_row(one.name, value, one.unit, _word(one), one.effect, carried)
    table.caption = "in brackets: standard error in units of the last digit"
    return table


def _word(one: Estimate) -> str:
    """Say what the shots know of an estimate."""
    if not one.determined:
        return "do not tell it"
    if one.none is None:
        return "tell it"
    return "show it" if one.found else "show none"
