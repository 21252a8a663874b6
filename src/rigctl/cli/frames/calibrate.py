"""`rigctl calibrate`: the camera from shots, with errors and effects, or its lens from a board."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from analysis.balls.lens.board import Board
from analysis.balls.lens.calibration import LensCalibration, calibrate_lens
from analysis.balls.lens.lens import write_lens
from analysis.calibration.calibrate import Calibration
from analysis.calibration.calibrate import calibrate as estimated
from analysis.calibration.estimate import Estimate
from analysis.campaign import read_campaign
from analysis.errors import InputError
from analysis.quantity import Quantity
from analysis.schema.codec import written
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


SEEN_TO = 0.8
"""Share of the half diagonal up to which corners must be seen, or it is said."""


def board_of(corners: str, square_mm: float | None, marker_mm: float | None) -> Board:
    """Return the board that the options describe; raise `SettingsError`."""
    match = re.fullmatch(r"(\d{1,2})x(\d{1,2})", corners)
    if match is None or min(int(part) for part in match.groups()) < 2:
        raise SettingsError(
            "no board",
            part="--board",
            value=repr(corners),
            limit="inner corners along and across, from 2 to 99 each, as in 9x6",
        )
    if square_mm is None:
        raise SettingsError(
            "is missing",
            part="--square-mm",
            todo="state the side of a square, as in --square-mm 20",
        )
    if marker_mm is not None and marker_mm >= square_mm:
        raise SettingsError(
            "is not smaller than a square",
            part="--marker-mm",
            value=f"{marker_mm:g} mm",
            limit=f"less than --square-mm {square_mm:g} mm",
        )
    columns, rows = (int(part) for part in match.groups())
    return Board(columns, rows, 1e-3 * square_mm, None if marker_mm is None else 1e-3 * marker_mm)


def calibrate_by_board(path: Path, board: Board, out: Path | None, *, as_json: bool) -> None:
    """Calibrate, write lens.toml where it is asked for, and print a table or one JSON document.

    Raises
    ------
    AnalysisInputError
        The pictures cannot be read, or do not show the board often enough.
    """
    try:
        console = Console(stderr=True)
        with Progress(console=console, transient=True, disable=not sys.stderr.isatty()) as bar:
            task = bar.add_task("looking for the board", total=None)
            result = calibrate_lens(
                path, board, lambda done, total: bar.update(task, completed=done, total=total)
            )
    except InputError as error:
        raise AnalysisInputError(error.reason, part=error.path) from error
    if out is not None:
        write_lens(out, result.lens)
    if as_json:
        print_json(_lens_document(path, result))
        return
    Console().print(_lens_table(path, result))
    if result.covered < SEEN_TO:
        print(  # noqa: T201
            f"corners were seen up to {result.covered:.0%} of the way to a corner of the picture; "
            "farther out the distortion is extrapolated: hold the board there too"
        )


def _lens_document(path: Path, result: LensCalibration) -> dict[str, object]:
    return {
        "film": str(path),
        "pictures": result.looked_at,
        "used": list(result.used),
        "rms_px": result.rms_px,
        "covered": result.covered,
        "lens": written(result.lens),
    }


def _lens_table(path: Path, result: LensCalibration) -> Table:
    lens = result.lens
    table = Table(
        title=f"{path.name}: the lens by {len(result.used)} views of {result.looked_at} pictures",
        title_justify="left",
        box=None,
    )
    for heading in ("estimate", "value", "unit"):
        table.add_column(heading, no_wrap=True)
    for name, value, sigma, unit in (
        ("focal length, vertical", lens.focal_px[0], lens.focal_sigma_px, "px"),
        ("focal length, horizontal", lens.focal_px[1], lens.focal_sigma_px, "px"),
        ("k1", lens.k1, lens.k1_sigma, "1"),
        ("k2", lens.k2, lens.k2_sigma, "1"),
        ("shift of the corner", lens.corner_px, lens.corner_sigma_px, "px"),
    ):
        table.add_row(name, Quantity(value, sigma, unit).concise(), unit)
    table.add_row("centre, row", f"{lens.centre_px[0]:.1f}", "px")
    table.add_row("centre, column", f"{lens.centre_px[1]:.1f}", "px")
    table.add_row("rms of corners", f"{result.rms_px:.3f}", "px")
    table.caption = "in brackets: standard error in units of the last digit"
    return table
