"""`rigctl find-discs`: centres and radii of the discs of one picture, with their errors."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from analysis.imaging.finding import FoundDisc, find_discs
from analysis.quantity import Quantity
from rigctl.errors import AnalysisInputError, SettingsError

SMALLEST_PX = 6.0
"""The limb of a smaller disc has too few pixels for a fit."""


def find(image: Path, diameters: str, *, sigma_px: float | None, as_json: bool) -> None:
    """Find the discs and print a table or one JSON document.

    Parameters
    ----------
    diameters
        Smallest and largest diameter in pixels, with a colon between.

    Raises
    ------
    SettingsError
        The range is none, or beyond what the picture holds.
    AnalysisInputError
        The picture cannot be read.
    """
    picture = _read(image)
    found = find_discs(picture, _range(diameters, min(picture.shape)), sigma_px)
    if as_json:
        document = {"image": str(image), "discs": [asdict(disc) for disc in found]}
        print(json.dumps(document, allow_nan=False))  # noqa: T201
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


def _read(image: Path) -> NDArray[np.uint8]:
    try:
        data = np.frombuffer(image.read_bytes(), dtype=np.uint8)
    except OSError as error:
        raise AnalysisInputError(
            f"cannot be read: {error.strerror or error}", part=str(image)
        ) from error
    picture = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE) if data.size else None
    if picture is None:
        raise AnalysisInputError(
            "is no picture", part=str(image), todo="give a PNG or TIFF of 8 bit"
        )
    return np.asarray(picture, dtype=np.uint8)
