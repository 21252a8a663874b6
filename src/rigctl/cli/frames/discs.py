"""`rigctl find-discs`: centres and radii of the discs of one picture, with their errors."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from analysis.balls.discs.disc import Disc
from analysis.balls.discs.finding import DOUBTFUL, SURE, find_balls
from analysis.balls.films.film import Picture
from analysis.balls.films.stacks import read_one
from analysis.errors import InputError
from analysis.quantity import Quantity
from rigctl.cli.options import Json
from rigctl.cli.output import print_json
from rigctl.errors import AnalysisInputError, SettingsError

ALLOWED = "give a PNG or TIFF of 8 or 16 bits, grey or colour"
SMALLEST_PX = 6.0
"""The limb of a smaller disc has too few pixels for a fit."""


def find_discs(
    image: Annotated[
        Path, typer.Argument(help="Picture: PNG or TIFF, grey or colour, 8 or 16 bits.")
    ],
    *,
    diameter_px: Annotated[
        str | None, typer.Option(help="Range of diameters in pixels, like 20:60; default: all.")
    ] = None,
    sigma_px: Annotated[
        float | None,
        typer.Option(min=0.5, max=8.0, help="Width of the edge filter in pixels."),
    ] = None,
    doubtful: Annotated[
        bool, typer.Option("--doubtful", help="Include discs that chance might show too.")
    ] = False,
    json: Json = False,
) -> None:
    """Find the discs and print a table or one JSON document.

    Raises
    ------
    SettingsError
        The range is none, or beyond what the picture holds.
    AnalysisInputError
        The picture cannot be read.
    """
    picture = read_image(image)
    side = min(picture.shape[:2])
    low, high = (2 * SMALLEST_PX, 0.7 * side) if diameter_px is None else _range(diameter_px, side)
    least = DOUBTFUL if doubtful else SURE
    found = find_balls(picture, (low / 2, high / 2), least, sigma_px=sigma_px)
    found = [disc for disc in found if low <= 2 * disc.radius <= high]
    if json:
        document = {"image": str(image), "discs": [_told(disc) for disc in found]}
        print_json(document)
        return
    table = Table(title=f"{image}: {len(found)} discs", title_justify="left", box=None)
    for heading in ("row px", "column px", "diameter px", "rim seen", "by chance"):
        table.add_column(heading, justify="right", no_wrap=True)
    for disc in found:
        table.add_row(*_cells(disc))
    table.caption = (
        "in brackets: standard error in units of the last digit; by chance: how many such discs a "
        "picture of this size would show whose edges point anywhere"
    )
    Console().print(table)


def _told(disc: Disc) -> dict[str, float]:
    return {**asdict(disc), "coverage": disc.rim}


def _cells(disc: Disc) -> tuple[str, ...]:
    lengths = (
        Quantity(disc.row, disc.row_sigma, "px"),
        Quantity(disc.column, disc.column_sigma, "px"),
        Quantity(2 * disc.radius, 2 * disc.radius_sigma, "px"),
    )
    return (
        *(length.concise() for length in lengths),
        f"{disc.rim:.0%}",
        f"10^{disc.log_alarms:.0f}",
    )


def _range(text: str, side_px: int) -> tuple[float, float]:
    try:
        low, high = (float(part) for part in text.split(":"))
    except ValueError as error:
        raise SettingsError(
            "no range of diameters",
            part="--diameter-px",
            value=repr(text),
            limit="two numbers with a colon between",
            todo="write for example --diameter-px 20:60",
        ) from error
    if not SMALLEST_PX <= low < high <= side_px:
        raise SettingsError(
            "diameters out of range",
            part="--diameter-px",
            value=f"{low:g} to {high:g} px",
            limit=f"{SMALLEST_PX:g} px to the picture's {side_px} px, the smaller first",
        )
    return low, high


def read_image(image: Path) -> Picture:
    """Return a picture with its channels; raise `AnalysisInputError` where it cannot be read."""
    try:
        return read_one(image)
    except InputError as error:
        raise AnalysisInputError(error.reason, part=str(image), todo=ALLOWED) from error
