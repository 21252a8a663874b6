"""Agreement and structure as other programs and the page read them."""

from __future__ import annotations

import json
from dataclasses import asdict, replace

import numpy as np

from analysis.arrays import Floats
from analysis.model.agreement.table import Agreement, Row
from analysis.model.structure.alarm import is_shared
from analysis.model.structure.findings import ALWAYS, Finding, findings
from analysis.model.structure.lackoffit import Cell
from analysis.model.structure.layout import covariate_label
from analysis.model.structure.structure import CellResiduals, Structure, Trend
from analysis.schema.agreement import (
    AgreementReport,
    AgreementRow,
    AgreementStage,
    CellPoints,
    CountedCell,
    Course,
    NoiseScale,
    SplitCell,
    StructureReport,
)
from analysis.schema.codec import SMALLEST_P, Json, written, written_all
from analysis.schema.verdict import TestedCell

DRAWN = 6
"""Of so many cells, the most striking ones, a document holds the residuals."""
MOST_POINTS = 1500
"""So many points of a cell are drawn at most."""
UNDETERMINED, BEST_TENTH = 30.0, 0.1
"""A point says nothing whose error is so many times that of the best tenth."""
DRAWN_DIGITS = 5
SEED = 1
"""Of the choice of points: the same cell is drawn the same way each time."""


def agreement_document(found: Agreement) -> Json:
    """Return the JSON of a table of agreement."""
    return written(agreement_report(found))


def agreement_report(found: Agreement) -> AgreementReport:
    """Return the table, its lines in stages, with p-values for having looked at all lines."""
    return AgreementReport(
        chi2=found.chi2,
        degrees_of_freedom=found.freedom,
        chi2_per_dof=found.chi2 / found.freedom,
        p_value=max(found.p_value, SMALLEST_P),
        prediction_error=found.prediction.value,
        prediction_error_sampling=found.prediction.sampling,
        noise={
            kind: NoiseScale(scale.value, scale.sigma if np.isfinite(scale.sigma) else None)
            for kind, scale in zip(("positions", "orientations"), found.noise, strict=True)
        },
        stages=tuple(
            AgreementStage(stage.name, tuple(map(_row, stage.rows))) for stage in found.stages
        ),
    )


def structure_document(found: Structure) -> Json:
    """Return the JSON of all cells, and the residuals of the most striking ones."""
    return written(structure_report(found))


def structure_report(found: Structure) -> StructureReport:
    """Return all cells, and the residuals of the most striking ones."""
    return StructureReport(
        cells=tuple(
            SplitCell(
                **asdict(tested_cell(cell)),
                deviation=cell.course_deviation,
                mean_deviation=cell.mean_deviation,
            )
            for cell in found.cells
        ),
        residuals=tuple(
            cell_points(found.residuals(cell.channel, cell.covariate))
            for cell in found.cells[:DRAWN]
        ),
    )


def cells_document(found: Structure) -> list[Json]:
    """Return the JSON of all cells, with whether more than two shots speak for each."""
    shots = len(found.data.shots)
    counted = [
        CountedCell(**asdict(tested_cell(cell)), shared=is_shared(cell, shots))
        for cell in found.cells
    ]
    return written_all(CountedCell, counted)


def findings_document(found: Structure) -> list[Json]:
    """Return means and courses as `findings` orders them, and the points behind each.

    Points are a text of JSON, to be parsed when they are looked at; those of a mean are in the
    order of firing.
    """
    return [
        {
            "channel": one.channel,
            "covariate": one.covariate,
            "deviation": one.deviation,
            "p_familywise": max(one.p_holm, SMALLEST_P),
            "points": json.dumps(drawn(_behind(found, one))),
        }
        for one in findings(found.cells, found.covariates)
    ]


def _behind(found: Structure, one: Finding) -> CellResiduals:
    if one.covariate == ALWAYS:
        return found.always(one.channel)
    return found.residuals(one.channel, one.covariate)


def cell_points(found: CellResiduals) -> CellPoints:
    """Return the points of a cell and their running mean."""
    trend = found.trend
    return CellPoints(
        channel=found.channel,
        covariate=found.covariate,
        x_label=covariate_label(found.covariate),
        unit=found.unit,
        shots=tuple(found.shots.tolist()),
        frames=tuple(found.frames.tolist()),
        x=tuple(found.place.tolist()),
        residual=tuple(found.residual.tolist()),
        sigma=tuple(found.sigma.tolist()),
        trend=Course(*(tuple(a.tolist()) for a in (trend.place, trend.mean, trend.sigma))),
    )


def drawn(found: CellResiduals) -> Json:
    """Return residuals with the digits that a picture shows, of very many a random choice.

    Points come in a fixed order of spheres and frames: a fixed stride would choose one sphere.
    Left out and counted as `undetermined` are those that lie along a direction in which nothing
    was measured, such as that of a sliding that hardly is one, towards the only camera.
    """
    best = np.quantile(found.sigma, BEST_TENTH) if found.sigma.size else np.inf
    known = found.sigma <= UNDETERMINED * best
    chosen = np.flatnonzero(known)
    count, undetermined = len(chosen), int((~known).sum())
    if count > MOST_POINTS:
        chosen = np.sort(np.random.default_rng(SEED).permutation(chosen)[:MOST_POINTS])
    some = replace(
        found,
        shots=found.shots[chosen],
        frames=found.frames[chosen],
        place=_rounded(found.place[chosen]),
        residual=_rounded(found.residual[chosen]),
        sigma=_rounded(found.sigma[chosen]),
        trend=Trend(*map(_rounded, (found.trend.place, found.trend.mean, found.trend.sigma))),
    )
    return {**written(cell_points(some)), "of": count, "undetermined": undetermined}


def _rounded(values: Floats) -> Floats:
    """Return values with `DRAWN_DIGITS` digits each."""
    size = np.abs(values)
    first = np.floor(np.log10(size, where=size > 0, out=np.zeros_like(size)))
    # Powers of ten from 1 on are exact: what they divide has no more digits than it shows.
    power = DRAWN_DIGITS - 1 - first
    up, down = 10.0 ** np.maximum(power, 0.0), 10.0 ** np.maximum(-power, 0.0)
    return np.asarray(np.rint(values * up / down) / up * down)


def _row(row: Row) -> AgreementRow:
    return AgreementRow(
        quantity=row.quantity,
        unit=row.unit,
        count=row.count,
        chi2=row.chi2,
        degrees_of_freedom=row.freedom,
        error=row.error,
        sampling=row.sampling,
        size=row.size,
        floor=row.floor,
        p_value=max(row.p_value, SMALLEST_P),
        p_familywise=max(row.p_holm, SMALLEST_P),
        shared=row.shared,
    )


def tested_cell(cell: Cell) -> TestedCell:
    """Return a cell with its chances."""
    return TestedCell(
        channel=cell.channel,
        covariate=cell.covariate,
        chi2=cell.chi2,
        degrees_of_freedom=cell.freedom,
        p_value=max(cell.p_value, SMALLEST_P),
        p_familywise=max(cell.p_holm, SMALLEST_P),
    )
