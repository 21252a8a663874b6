"""`rigctl find-discs`: centres and radii of the discs of one picture, with their errors."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from analysis.errors import InputError
from analysis.files import FrameBudget
from analysis.imaging import finding
from analysis.imaging.files.png_files import read_picture
from analysis.imaging.files.stack import TIFF_SUFFIXES
from analysis.imaging.files.tiff_file import read_tiff
from analysis.imaging.finding import FoundDisc
from analysis.quantity import Quantity
from rigctl.cli.options import Json
from rigctl.cli.output import print_json
from rigctl.errors import AnalysisInputError, SettingsError

ALLOWED = "give a PNG or TIFF of 8 bit"
GREY_BGR = (0.114, 0.587, 0.299)
"""Shares of blue, green and red in a grey level (ITU-R BT.601)."""
SMALLEST_PX = 6.0
"""The limb of a smaller disc has too few pixels for a fit."""


def find_discs(
    image: Annotated[Path, typer.Argument(help="Picture: PNG, TIFF or whatever OpenCV reads.")],
    *,
    diameter_px: Annotated[str, typer.Option(help="Range of diameters in pixels, like 20:60.")],
    sigma_px: Annotated[
        float | None,
        typer.Option(min=0.5, max=8.0, help="Width of the edge filter in pixels."),
    ] = None,
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
    picture = read_grey(image)
    found = finding.find_discs(picture, _range(diameter_px, min(picture.shape)), sigma_px)
    if json:
        print_json({"image": str(image), "discs": [asdict(disc) for disc in found]})
        return
    table = Table(title=f"{image}: {len(found)} discs", title_justify="left", box=None)
    for heading in ("row px", "column px", "diameter px", "rim seen"):
        table.add_column(heading, justify="right", no_wrap=True)
    for disc in found:
        table.add_row(*_cells(disc))
    table.caption = "in brackets: standard error in units of the last digit"
    Console().print(table)


def _cells(disc: FoundDisc) -> tuple[str, ...]:
    lengths = (
        Quantity(disc.row, disc.row_sigma, "px"),
        Quantity(disc.column, disc.column_sigma, "px"),
        Quantity(2 * disc.radius, 2 * disc.radius_sigma, "px"),
    )
    return (*(length.concise() for length in lengths), f"{disc.coverage:.0%}")


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


def read_grey(image: Path) -> NDArray[np.uint8]:
    """Return a picture in grey levels; raise `AnalysisInputError` where it cannot be read."""
    budget, tiff = FrameBudget(image), image.suffix.lower() in TIFF_SUFFIXES
    try:
        picture = read_tiff(image, budget)[0] if tiff else read_picture(image, budget)
    except (InputError, OSError) as error:
        why = error.reason if isinstance(error, InputError) else f"cannot be read: {error.strerror}"
        raise AnalysisInputError(why, part=str(image), todo=ALLOWED) from error
    if picture.ndim == 3 and picture.shape[2] < 3:
        picture = picture[..., 0]
    if picture.dtype != np.uint8:
        raise AnalysisInputError(f"holds {picture.dtype} values", part=str(image), todo=ALLOWED)
    if picture.ndim == 2:
        return picture.astype(np.uint8, copy=False)
    weights = np.array(GREY_BGR if not tiff else GREY_BGR[::-1])
    return np.asarray(np.rint(picture[..., :3] @ weights), dtype=np.uint8)
