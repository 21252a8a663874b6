"""`rigctl reanalyse`: a stored campaign by another method or version, compared with before."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from dataclasses import asdict
from json import dumps
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from rigctl.cli.options import Config, Json, MeasuredBy, StoredCampaign, Workers
from rigctl.cli.output import bar
from rigctl.cli.spool import Spool, print_document
from rigctl.config import load
from rigctl.opening import own_store, read_store
from rigctl.reanalysis import Comparison, Comparisons, Outcome, pool, reanalyse_campaign
from rigctl.store import ShotState


def reanalyse(
    campaign: StoredCampaign,
    *,
    method: MeasuredBy = "photometric",
    scheduler: Annotated[
        str | None,
        typer.Option(help="Address of a Dask scheduler; without it processes of this host."),
    ] = None,
    workers: Workers = None,
    config: Config = None,
    json: Json = False,
) -> None:
    """Analyse a campaign once more and print how its results changed.

    Raises
    ------
    NotFoundError, AnalysisFailedError, ConfigurationError, StoreError
        As `reanalyse_campaign`, `pool` and `Spool`.
    """
    with read_store(config) as reader:
        reader.campaigns.one(campaign)
    compared, measured, shots = Comparisons(), 0, 0
    with Spool() as lines:
        with (
            closing(own_store(load(config), shared=True)) as store,
            pool(scheduler, workers) as workshop,
            bar() as report,
        ):
            for outcome in reanalyse_campaign(store, campaign, method, workshop, report):
                compared.add(outcome)
                shots += 1
                measured += _is_measured(outcome)
                if (line := _object(outcome) if json else _sentence(outcome)) is not None:
                    lines.add(line)
        changes = compared.found()
        if json:
            head = {"campaign": campaign, "method": method}
            print_document(head, "shots", lines, {"changes": [asdict(c) for c in changes]})
            return
        console = Console(highlight=False, soft_wrap=True, markup=False)
        console.print(f"campaign {campaign}, {method}: {measured} of {shots} shots measured")
        if changes:
            console.print(_table(changes))
        for line in lines.lines():
            console.print(line)


def _is_measured(outcome: Outcome) -> bool:
    return outcome.failure is None and outcome.shot.state is ShotState.ANALYSED


def _object(outcome: Outcome) -> str:
    """Return what became of a shot as JSON."""
    about = {
        "shot": outcome.shot.id,
        "state": outcome.shot.state,
        "result": outcome.shot.results if outcome.failure is None else None,
        "failure": outcome.failure or outcome.shot.failure,
    }
    return dumps(about)


def _sentence(outcome: Outcome) -> str | None:
    """Say why a shot was not measured; None: it was."""
    if outcome.failure is not None:
        return f"shot {outcome.shot.id} keeps what it has: {_line(outcome.failure)}"
    if outcome.shot.state is ShotState.REFUSED:
        return f"shot {outcome.shot.id} refused: {_line(outcome.shot.failure or '')}"
    return None


def _line(text: str) -> str:
    return " ".join(text.split())


def _table(changes: Sequence[Comparison]) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0), title_justify="left")
    table.title = "later minus earlier result"
    for heading in ("quantity", "unit", "shots", "mean", "rms", "rms in its errors"):
        table.add_column(heading, justify="left" if heading in {"quantity", "unit"} else "right")
    for change in changes:
        sigmas = "" if change.rms_sigmas is None else f"{change.rms_sigmas:.2f}"
        numbers = (f"{change.shots}", f"{change.mean:+.2g}", f"{change.rms:.2g}", sigmas)
        unit = "" if change.unit == "1" else change.unit
        table.add_row(change.quantity, unit, *numbers)
    return table
