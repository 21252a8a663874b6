"""`rigctl model agreement`: where the model and the campaign agree, and where they do not."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from analysis.effects.own.fault import EffectFault
from analysis.errors import LaunchRefusedError
from analysis.model.agreement.agree import agree
from analysis.model.agreement.document import agreement_document, structure_document
from analysis.model.agreement.launch import launch_stage
from analysis.model.agreement.table import Agreement, Row, Stage, probability, three_digits
from analysis.model.plane import impact_plane
from analysis.model.structure.lackoffit import Cell
from analysis.model.structure.structure import structure
from analysis.model.verdict.documents import fit_document
from rigctl.cli.model.reading import Fitted, fitted, report_faults
from rigctl.cli.options import Campaign, Config, Json, OwnEffects, Pictures, Streamed, With
from rigctl.cli.output import TABLE_WIDTH, print_json, progress
from rigctl.model.headline import headline
from rigctl.model.known_effects import available, refused
from rigctl.temporary_room import temporary_room

ALARM = 0.01
SHOWN_CELLS = 8


def agreement(
    campaign: Campaign,
    *,
    effects: With = None,
    folder: OwnEffects = None,
    out: Pictures = None,
    stream: Streamed = False,
    config: Config = None,
    json: Json = False,
) -> None:
    """Hold the base model and the named effects against a campaign; print where they fail.

    Raises
    ------
    AnalysisInputError
        The campaign or the folder cannot be read, or a named effect has a fault.
    NotFoundError
        No effect has that name.
    StoreError
        The temporary folder is full, or a picture cannot be written.
    """
    known = available(folder)
    found = fitted(campaign, effects or [], known, config, stream=stream)
    try:
        with progress() as report, temporary_room():
            report("comparing")
            compared = agree(found.data, found.fit, _launch(found))
            report("testing what is left")
            left = structure(found.data, found.fit)
            plane = impact_plane(found.data, found.fit)
    except EffectFault as error:
        raise refused(error.fault) from error
    faults = report_faults(known.faults)
    if json:
        document = fit_document(found.title, found.names, found.robust)
        document |= agreement_document(compared)
        document |= {"structure": structure_document(left), "plane": plane.to_json()}
        print_json({**document, "faults": faults})
    else:
        console = Console(width=TABLE_WIDTH)
        console.print(headline(found.title, found.robust), highlight=False)
        console.print(_summary(compared), highlight=False)
        console.print(_table(compared))
        console.print(_cells(left.cells))
    if out is not None:
        # Without pictures nothing waits for what draws them.
        from rigctl.cli.model.pictures import draw_agreement  # noqa: PLC0415

        draw_agreement(out, found.title, compared, left, plane)


def _launch(found: Fitted) -> tuple[Stage, ...]:
    """Return the stage of the launch; say why, where there is none."""
    try:
        return (launch_stage(found.data, found.fit),)
    except LaunchRefusedError as error:
        Console(stderr=True).print(f"the launch is left out: {error}", highlight=False)
        return ()


def _summary(found: Agreement) -> str:
    positions, orientations = found.noise
    error = (
        f"error on shots left out {found.prediction.value:.4f} of the noise (floor 1, sampling "
        f"error {found.prediction.sampling:.4f})"
    )
    if math.isinf(positions.sigma) and math.isinf(orientations.sigma):
        return error
    return (
        f"{error}; noise {positions.value:.3f} of what is stated for positions, "
        f"{orientations.value:.3f} for orientations"
    )


def _table(found: Agreement) -> Table:
    table = Table(box=None)
    for heading in ("", "chi²", "dof", "p", "error / noise", "error", "floor", "unit"):
        left = heading in {"", "unit"}
        table.add_column(heading, justify="left" if left else "right", no_wrap=True)
    for stage in found.stages:
        table.add_row(stage.name, style="bold")
        for row in stage.rows:
            table.add_row(*_fields(row), style="bold" if row.p_holm < ALARM else None)
    table.caption = (
        "p: chance of as much by noise, all lines looked at; error: what a prediction misses, root "
        "mean square, beside what noise alone makes of it; bold: p below 0.01"
    )
    return table


def _fields(row: Row) -> tuple[str, ...]:
    return (
        f"  {row.quantity}",
        f"{row.chi2:.1f}",
        f"{row.freedom:.1f}",
        probability(row.p_holm),
        f"{row.error:.3f} ± {row.sampling:.3f}",
        three_digits(row.size),
        three_digits(row.floor),
        row.unit,
    )


def _cells(cells: Sequence[Cell]) -> Table:
    table = Table(title="structure that is left", title_justify="left", box=None)
    for heading in ("of", "against", "chi²", "dof", "p"):
        left = heading in {"of", "against"}
        table.add_column(heading, justify="left" if left else "right", no_wrap=True)
    for cell in cells[:SHOWN_CELLS]:
        chi2, p = f"{cell.chi2:.1f}", probability(cell.p_holm)
        fields = (cell.channel, cell.covariate, chi2, str(cell.freedom), p)
        table.add_row(*fields, style="bold" if cell.p_holm < ALARM else None)
    table.caption = f"the {min(SHOWN_CELLS, len(cells))} most striking of {len(cells)} cells"
    return table
