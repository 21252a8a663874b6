"""The residuals of one cell of the heat map, with their running mean."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from analysis.figures.palette import FAILS, GREY, MEASURED
from analysis.figures.sheet import plain, sheet
from analysis.model.agreement.table import probability
from analysis.model.structure.lackoffit import Cell
from analysis.model.structure.layout import covariate_label
from analysis.model.structure.structure import CellResiduals

BAND = 2.0
"""Standard errors that the band reaches to each side."""
MANY = 300
"""With more points, their own errors would cover them."""
SHOWN = 99.5
"""Per cent of the points that the picture holds at least."""


def residuals_figure(title: str, cell: Cell, found: CellResiduals) -> Figure:
    """Draw the residual of every shot, or every frame, against the covariate of a cell."""
    by_shot, many = bool((found.frames < 0).all()), len(found.place) > MANY
    first = (
        "Each point is a shot: by how much its poses want this changed"
        if by_shot
        else "Each point is a frame: what is left of it beside the fitted curve"
    )
    line = "running mean" if by_shot else "smooth curve that the poses want"
    errors = "" if many else ", with its standard error"
    note = (
        f"{first}{errors}.\nLine: {line}, with two standard errors. χ² = {cell.chi2:.1f} for "
        f"{cell.freedom} degrees of freedom.\nChance of as much with all cells looked at: "
        f"{probability(cell.p_holm)}."
    )
    figure = sheet(7.6, 5.1, f"{title}: {found.channel} against {found.covariate}", note)
    axes = figure.add_subplot()
    plain(axes)
    axes.axhline(0.0, color=GREY, linewidth=1.0)
    axes.errorbar(
        found.place,
        found.residual,
        yerr=None if many else found.sigma,
        fmt="o",
        color=MEASURED,
        markersize=2.0 if many else 4.0,
        alpha=0.35 if many else 0.8,
        elinewidth=0.6,
        ecolor="#9CC7E3",
        markeredgewidth=0,
    )
    trend = found.trend
    reach = BAND * trend.sigma
    axes.fill_between(
        trend.place, trend.mean - reach, trend.mean + reach, color=FAILS, alpha=0.25, linewidth=0
    )
    axes.plot(trend.place, trend.mean, color=FAILS, linewidth=2.0)
    if found.residual.size:
        edge = 1.15 * float(np.percentile(np.abs(found.residual), SHOWN))
        axes.set_ylim(-edge, edge)
    axes.set_xlabel(covariate_label(found.covariate))
    axes.set_ylabel(f"{found.channel}, residual ({found.unit})")
    return figure
