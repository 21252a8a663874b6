"""Commands that write a campaign for other systems."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rigctl.command_line.options import Config

exporting = typer.Typer()

Campaign = Annotated[Path, typer.Argument(help="Campaign folder, or name of a campaign.")]


@exporting.command("export-nexus")
def export_nexus(
    campaign: Campaign,
    file: Annotated[Path, typer.Argument(help="NeXus file (HDF5) to be written.")],
    *,
    config: Config = None,
) -> None:
    """Write poses, coefficients and their origin as a NeXus file."""
    from rigctl.commands.stored.export_other import export_nexus as write

    write(campaign, file, config)


@exporting.command("export-events")
def export_events(
    campaign: Campaign,
    file: Annotated[Path, typer.Argument(help="File to be written, a document a line.")],
    *,
    config: Config = None,
) -> None:
    """Write a campaign as documents of the event model."""
    from rigctl.commands.stored.export_other import export_events as write

    write(campaign, file, config)
