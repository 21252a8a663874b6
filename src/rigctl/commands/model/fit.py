"""`rigctl model fit`: the parameters that all shots share."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from analysis.model.verdict.documents import fit_document
from rigctl.commands.effect import tell
from rigctl.commands.model.printing import TABLE_WIDTH, print_json
from rigctl.commands.model.reading import Fitted, FittedStream, fitted, fitted_stream
from rigctl.model.headline import headline
from rigctl.model.known_effects import available


def fit(
    campaign: Path,
    names: Sequence[str],
    *,
    as_json: bool,
    folder: Path | None = None,
    configuration: Path | None = None,
    stream: bool = False,
) -> None:
    """Fit the base model and the named effects; print parameters with standard errors.

    Parameters
    ----------
    folder
        Where the user's own effects are.
    configuration
        Of the rig whose store holds a campaign that is named; None: the simulated rig's.
    stream
        Whether poses.csv is gone over so many shots at a time.

    Raises
    ------
    AnalysisInputError
        The campaign or the folder cannot be read, or a named effect has a fault.
    NotFoundError
        No effect has that name.
    StoreError
        The temporary folder is full.
    """
    known = available(folder)
    read = fitted_stream if stream else fitted
    found: Fitted | FittedStream = read(campaign, names, known, configuration)
    faults = tell(known.faults)
    if as_json:
        document = fit_document(found.title, found.names, found.judged)
        print_json({**document, "faults": faults})
        return
    console = Console(width=TABLE_WIDTH)
    console.print(headline(found.title, found.judged), highlight=False)
    table = Table(box=None)
    for heading in ("parameter", "value", "unit"):
        table.add_column(heading, justify="left" if heading != "value" else "right")
    for name, quantity in found.judged.fit.parameters().items():
        table.add_row(name, quantity.concise(), "" if quantity.unit == "1" else quantity.unit)
    console.print(table)
