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
from analysis.schema.codec import SMALLEST_P, Json

DRAWN = 6
"""Of so many cells, the most striking ones, a document holds the residuals."""
MOST_POINTS = 1500
"""So many points of a cell are drawn at most."""
DRAWN_DIGITS = 5
SEED = 1
"""Of the choice of points: the same cell is drawn the same way each time."""


def agreement_document(found: Agreement) -> Json:
    """Return the table, its lines in stages, with p-values for having looked at all lines."""
    return {
        "chi2": found.chi2,
        "degrees_of_freedom": found.freedom,
        "chi2_per_dof": found.chi2 / found.freedom,
        "p_value": max(found.p_value, SMALLEST_P),
        "prediction_error": found.prediction.value,
        "prediction_error_sampling": found.prediction.sampling,
        "noise": {
            kind: {"value": scale.value, "sigma": scale.sigma if np.isfinite(scale.sigma) else None}
            for kind, scale in zip(("positions", "orientations"), found.noise, strict=True)
        },
        "stages": [
            {
                "stage": stage.name,
                "quantities": [_row(row) for row in stage.rows],
            }
            for stage in found.stages
        ],
    }


def structure_document(found: Structure) -> Json:
    """Return all cells, and the residuals of the most striking ones.

    `deviation`: standard deviations of a cell's course without its channel's mean, and
    `mean_deviation` those of that mean.
    """
    return {
        "cells": [_split(cell) for cell in found.cells],
        "residuals": [
            residuals_document(found.residuals(cell.channel, cell.covariate))
            for cell in found.cells[:DRAWN]
        ],
    }


def cells_document(found: Structure) -> list[Json]:
    """Return all cells; `shared`: whether more than two shots speak for it."""
    shots = len(found.data.shots)
    return [{**cell_document(cell), "shared": is_shared(cell, shots)} for cell in found.cells]


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


def residuals_document(found: CellResiduals) -> Json:
    """Return the points of a cell and their running mean, arrays as lists."""
    trend = found.trend
    return {
        "channel": found.channel,
        "covariate": found.covariate,
        "x_label": covariate_label(found.covariate),
        "unit": found.unit,
        "shots": found.shots.tolist(),
        "frames": found.frames.tolist(),
        "x": found.place.tolist(),
        "residual": found.residual.tolist(),
        "sigma": found.sigma.tolist(),
        "trend": {
            "x": trend.place.tolist(),
            "mean": trend.mean.tolist(),
            "sigma": trend.sigma.tolist(),
        },
    }


def drawn(found: CellResiduals) -> Json:
    """Return residuals with the digits that a picture shows, of very many a random choice.

    Points come in a fixed order of spheres and frames: a fixed stride would choose one sphere.
    """
    count = len(found.place)
    chosen = np.arange(count)
    if count > MOST_POINTS:
        chosen = np.sort(np.random.default_rng(SEED).permutation(count)[:MOST_POINTS])
    some = replace(
        found,
        shots=found.shots[chosen],
        frames=found.frames[chosen],
        place=_rounded(found.place[chosen]),
        residual=_rounded(found.residual[chosen]),
        sigma=_rounded(found.sigma[chosen]),
        trend=Trend(*map(_rounded, (found.trend.place, found.trend.mean, found.trend.sigma))),
    )
    return {**residuals_document(some), "of": count}


def _rounded(values: Floats) -> Floats:
    """Return values with `DRAWN_DIGITS` digits each."""
    size = np.abs(values)
    first = np.floor(np.log10(size, where=size > 0, out=np.zeros_like(size)))
    # Powers of ten from 1 on are exact: what they divide has no more digits than it shows.
    power = DRAWN_DIGITS - 1 - first
    up, down = 10.0 ** np.maximum(power, 0.0), 10.0 ** np.maximum(-power, 0.0)
    return np.asarray(np.rint(values * up / down) / up * down)


def _row(row: Row) -> Json:
    document = asdict(row)
    document["degrees_of_freedom"] = document.pop("freedom")
    del document["p_holm"]
    document["p_value"] = max(row.p_value, SMALLEST_P)
    document["p_familywise"] = max(row.p_holm, SMALLEST_P)
    return document


def cell_document(cell: Cell) -> Json:
    """Return a cell: `p_value` of it by itself, `p_familywise` with all cells looked at."""
    return {
        "channel": cell.channel,
        "covariate": cell.covariate,
        "chi2": cell.chi2,
        "degrees_of_freedom": cell.freedom,
        "p_value": max(cell.p_value, SMALLEST_P),
        "p_familywise": max(cell.p_holm, SMALLEST_P),
    }


def _split(cell: Cell) -> Json:
    """Return a cell with its deviations, the mean of its channel taken out, and of that mean."""
    return {
        **cell_document(cell),
        "deviation": cell.course_deviation,
        "mean_deviation": cell.mean_deviation,
    }
