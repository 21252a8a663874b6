"""`rigctl reanalyse`: a stored campaign by another method or version, compared with before."""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import closing
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from rigctl.commands.bar import bar
from rigctl.config import load
from rigctl.opening import own_store, read_store
from rigctl.reanalysis import Comparison, Outcome, compared, pool, reanalyse_campaign
from rigctl.store import ShotState


def reanalyse(
    campaign: str,
    method: str,
    configuration: Path | None,
    *,
    scheduler: str | None,
    workers: int | None,
    as_json: bool,
) -> None:
    """Analyse a campaign once more and print how its results changed.

    Raises
    ------
    NotFoundError, ConfigurationError, StoreError
        As `reanalyse_campaign` and `pool`.
    """
    with read_store(configuration) as reader:
        reader.campaigns.one(campaign)
    with (
        closing(own_store(load(configuration), shared=True)) as store,
        pool(scheduler, workers) as executor,
        bar() as say,
    ):
        outcomes = reanalyse_campaign(store, campaign, method, executor, say)
    changes = compared(outcomes)
    if as_json:
        print(json.dumps(_document(campaign, method, outcomes, changes), allow_nan=False))  # noqa: T201
    else:
        _print(campaign, method, outcomes, changes)


def _document(
    campaign: str, method: str, outcomes: Sequence[Outcome], changes: Sequence[Comparison]
) -> dict[str, Any]:
    return {
        "campaign": campaign,
        "method": method,
        "shots": [
            {
                "shot": outcome.shot.id,
                "state": outcome.shot.state,
                "result": outcome.shot.results if outcome.failure is None else None,
                "failure": outcome.failure or outcome.shot.failure,
            }
            for outcome in outcomes
        ],
        "changes": [asdict(change) for change in changes],
    }


def _print(
    campaign: str, method: str, outcomes: Sequence[Outcome], changes: Sequence[Comparison]
) -> None:
    console = Console(highlight=False, soft_wrap=True, markup=False)
    measured = sum(o.failure is None and o.shot.state is ShotState.ANALYSED for o in outcomes)
    console.print(f"campaign {campaign}, {method}: {measured} of {len(outcomes)} shots measured")
    if changes:
        console.print(_table(changes))
    for outcome in outcomes:
        if outcome.failure is not None:
            console.print(f"shot {outcome.shot.id} keeps what it has: {outcome.failure}")
        elif outcome.shot.state is ShotState.REFUSED:
            console.print(f"shot {outcome.shot.id} refused: {outcome.shot.failure}")


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
