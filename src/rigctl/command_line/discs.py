"""`rigctl find-discs`: round things of any size in one picture."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rigctl.command_line.options import Json

finding = typer.Typer()


@finding.command("find-discs")
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
    """Find all discs of a picture within a range of diameters."""
    from rigctl.commands.analysis.discs import find

    find(image, diameter_px, sigma_px=sigma_px, as_json=json)
