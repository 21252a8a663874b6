"""Figures that commands write."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import typer
from matplotlib.figure import Figure

from analysis.figures.sheet import write
from rigctl.errors import StoreError


def write_figures(folder: Path, figures: Iterable[tuple[str, Figure]]) -> None:
    """Write named figures as PNG and SVG; their paths stand on standard error.

    Raises
    ------
    StoreError
        One cannot be written.
    """
    try:
        for name, figure in figures:
            for path in write(figure, folder, name):
                typer.echo(f"{path}", err=True)
    except OSError as error:
        raise StoreError(
            f"a picture cannot be written: {error.strerror or error}",
            part=str(error.filename or folder),
            todo="free the disk or choose another folder with --out",
        ) from error
