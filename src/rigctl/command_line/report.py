"""The command that writes the results of a campaign."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rigctl.command_line.options import Config

reporting = typer.Typer()


@reporting.command()
def report(
    campaign: Annotated[Path, typer.Argument(help="Campaign folder, or name of a campaign.")],
    *,
    out: Annotated[Path, typer.Option(help="Write the report, one HTML file, here.")],
    csv: Annotated[
        Path | None, typer.Option(help="Write the table behind every figure into this folder.")
    ] = None,
    config: Config = None,
) -> None:
    """Write the results of a campaign: coefficients, figure 7.4, restitution against speed."""
    from rigctl.commands.stored.report_campaign import report_campaign

    report_campaign(campaign, out, csv=csv, configuration=config)
