"""`rigctl export-nexus` and `rigctl export-events`: a campaign for other systems."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from rigctl.cli.options import Campaign, Config
from rigctl.errors import ConfigurationError
from rigctl.exports.event_documents import write_documents
from rigctl.reports.campaign import measured_results
from rigctl.reports.source import open_source


def require(library: str, extra: str) -> None:
    """Make sure that a library of an extra is there.

    Raises
    ------
    ConfigurationError
        It is not installed.
    """
    if find_spec(library) is None:
        raise ConfigurationError(
            f"the library {library} is not installed",
            part=f"extra {extra}",
            todo=f"install rigctl[{extra}]",
        )


def export_nexus(
    campaign: Campaign,
    file: Annotated[Path, typer.Argument(help="NeXus file (HDF5) to be written.")],
    *,
    config: Config = None,
) -> None:
    """Write a campaign and its results as a NeXus file.

    Raises
    ------
    ConfigurationError
        The extra hdf5 is not installed.
    AnalysisInputError, NotFoundError
        The campaign cannot be read or has no measured impact.
    StoreError
        The file is there already, or cannot be written.
    """
    require("h5py", "hdf5")
    # An extra's library is loaded where it is wanted.
    from rigctl.exports.nexus import write_nexus  # noqa: PLC0415

    source = open_source(campaign, config)
    write_nexus(file, source, measured_results(source))


def export_events(
    campaign: Campaign,
    file: Annotated[Path, typer.Argument(help="File to be written, a document a line.")],
    *,
    config: Config = None,
) -> None:
    """Write a campaign as documents of the event model, a line of JSON each.

    Raises
    ------
    AnalysisInputError, NotFoundError
        The campaign cannot be read, has no measured impact, or a shot has no time.
    StoreError
        The file is there already, or cannot be written.
    """
    source = open_source(campaign, config)
    write_documents(file, source, measured_results(source))
