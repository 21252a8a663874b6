"""`rigctl model fit`: the parameters that all shots share."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table

from analysis.model.fitting.nuisance import nuisances
from analysis.model.fitting.nuisance_words import nuisance_lines
from analysis.model.verdict.documents import fit_document
from rigctl.cli.model.reading import fitted, report_faults
from rigctl.cli.options import Campaign, Config, Json, OwnEffects, Streamed, With
from rigctl.cli.output import TABLE_WIDTH, print_json, unit_word
from rigctl.model.headline import headline
from rigctl.model.known_effects import available


def fit(
    campaign: Campaign,
    *,
    effects: With = None,
    folder: OwnEffects = None,
    stream: Streamed = False,
    config: Config = None,
    json: Json = False,
) -> None:
    """Fit the base model and the named effects; print parameters with standard errors.

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
    found = fitted(campaign, effects or [], known, config, stream=stream)
    faults = report_faults(known.faults)
    if json:
        document = fit_document(found.title, found.names, found.robust)
        print_json({**document, "faults": faults})
        return
    console = Console(width=TABLE_WIDTH)
    console.print(headline(found.title, found.robust), highlight=False)
    table = Table(box=None)
    for heading in ("parameter", "value", "unit"):
        table.add_column(heading, justify="left" if heading != "value" else "right")
    for name, quantity in found.robust.fit.parameters().items():
        table.add_row(name, quantity.concise(), unit_word(quantity.unit))
    console.print(table)
    for line in nuisance_lines(nuisances(found.robust.fit)):
        console.print(line, highlight=False)
