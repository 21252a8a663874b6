"""Commands that measure frames."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from rigctl.command_line.options import Json

analysis = typer.Typer()


class Method(StrEnum):
    """How images are measured."""

    THESIS = "thesis"
    PHOTOMETRIC = "photometric"


class MarkerMatching(StrEnum):
    """How markers are matched from frame to frame."""

    PATTERN = "pattern"
    PROXIMAL = "proximal"


@analysis.command()
def analyse(
    paths: Annotated[
        list[Path], typer.Argument(help="Campaign folders, or frames: TIFF, NPY, AVI, PNG folder.")
    ],
    *,
    method: Annotated[Method, typer.Option(help="How images are measured.")] = Method.PHOTOMETRIC,
    setup: Annotated[
        Path | None,
        typer.Option(help="A campaign.toml for frames that belong to no campaign folder."),
    ] = None,
    sigma_px: Annotated[
        float | None,
        typer.Option(min=0.5, max=8.0, help="Thesis method: width of the edge filter, pixels."),
    ] = None,
    samples: Annotated[
        int | None,
        typer.Option(min=1, max=16, help="Thesis method: facet samples a pixel. Default: exact."),
    ] = None,
    matching: Annotated[
        MarkerMatching | None,
        typer.Option(help="Thesis method: markers by rigid pattern, or frame to frame."),
    ] = None,
    three: Annotated[
        bool, typer.Option("--three", help="Three frames before and three after, 2 ms apart.")
    ] = False,
    out: Annotated[
        Path | None, typer.Option(help="Write an exchange folder with poses and contacts here.")
    ] = None,
    figures: Annotated[
        Path | None, typer.Option(help="Write one picture a shot into this folder.")
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, max=256, help="Processes; default: one a processor.")
    ] = None,
    json: Json = False,
) -> None:
    """Measure the collisions in frames."""
    from rigctl.commands.analysis.analyse import Request
    from rigctl.commands.analysis.analyse import analyse as measure

    request = Request(
        paths=paths,
        setup=setup,
        sigma_px=sigma_px,
        samples_per_pixel=samples,
        matching=None if matching is None else matching.value,
        three_and_three=three,
        out=out,
        figures=figures,
        workers=workers,
        method=method.value,
    )
    measure(request, as_json=json)
