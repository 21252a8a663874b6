"""`rigctl report`: the results of a campaign as one HTML file, and as tables."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from analysis.quantity import Quantity
from analysis.results.campaign import Results
from analysis.results.tables import tables
from rigctl.cli.options import Campaign, Config
from rigctl.errors import StoreError
from rigctl.reports.campaign import measured_results
from rigctl.reports.html import csv_text
from rigctl.reports.page import page
from rigctl.reports.source import open_source


def report(
    campaign: Campaign,
    *,
    out: Annotated[Path, typer.Option(help="Write the report, one HTML file, here.")],
    csv: Annotated[
        Path | None, typer.Option(help="Write the table behind every figure into this folder.")
    ] = None,
    config: Config = None,
) -> None:
    """Write the report of a campaign, and every table behind its figures into a folder.

    Raises
    ------
    AnalysisInputError
        The campaign cannot be read, or no shot of it has a measured impact.
    NotFoundError
        There is neither such a folder nor such a campaign, or none of its shots is measured.
    StoreError
        The report cannot be written.
    """
    source = open_source(campaign, config)
    found = measured_results(source)
    try:
        out.write_text(page(source, found), encoding="utf-8")
        if csv is not None:
            csv.mkdir(parents=True, exist_ok=True)
            for name, rows in tables(found).items():
                (csv / f"{name}.csv").write_text(csv_text(rows), encoding="utf-8")
    except OSError as error:
        raise StoreError(
            f"cannot be written: {error.strerror or error}",
            part=str(error.filename or out),
            todo="free the disk, or choose another place with --out and --csv",
        ) from error
    Console(stderr=True).print(f"{out}", highlight=False, soft_wrap=True)
    print(_said(found))  # noqa: T201


def _said(found: Results) -> str:
    regression = _listed(found.coefficients())
    if not found.lasting:
        return regression
    return (
        f"mean of the shots: {regression}; the contacts last, and mu and beta0 of two lines are "
        f"no law of theirs: fitted {_listed(found.whole_fit)}"
    )


def _listed(parameters: Mapping[str, Quantity]) -> str:
    return ", ".join(f"{name} = {q.concise()}" for name, q in parameters.items())
