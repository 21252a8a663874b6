"""The pictures of `rigctl model --out`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from matplotlib.figure import Figure

from analysis.figures.agreement import agreement_figure
from analysis.figures.error_path import error_path_figure
from analysis.figures.heatmap import heatmap_figure
from analysis.figures.plane import plane_figure
from analysis.figures.ranking import aliases_figure, ranking_figure
from analysis.figures.residuals import residuals_figure
from analysis.model.agreement.table import Agreement
from analysis.model.plane import Plane, impact_plane
from analysis.model.rank.candidate import Ranking
from analysis.model.structure.structure import Structure
from analysis.model.verdict.selection import Verdict
from rigctl.cli.figures import write_figures

MOST_RESIDUALS = 4
"""Of so many cells the residuals are drawn."""

Named = Iterator[tuple[str, Figure]]


def draw_agreement(
    folder: Path, title: str, compared: Agreement, left: Structure, plane: Plane
) -> None:
    """Write the table, the heat map, the residuals of its most striking cells and figure 7.4.

    Their paths stand on standard error; so in the functions below.

    Raises
    ------
    StoreError
        A picture cannot be written; so in the functions below.
    """

    def figures() -> Named:
        yield "agreement", agreement_figure(f"{title}: model against measurement", compared)
        yield "structure", heatmap_figure(f"{title}: where it fails", left.cells)
        for place, cell in enumerate(left.cells[:MOST_RESIDUALS], start=1):
            residuals = left.residuals(cell.channel, cell.covariate)
            yield f"residuals-{place}", residuals_figure(title, cell, residuals)
        yield "rebound", plane_figure(f"{title}: rebound of the surface velocity", plane)

    write_figures(folder, figures())


def draw_ranking(folder: Path, title: str, ranking: Ranking) -> None:
    """Write the scores and the correlations of the candidates."""
    write_figures(folder, _of_ranking(title, ranking))


def draw_explanation(folder: Path, title: str, verdict: Verdict) -> None:
    """Write the error path, the first ranking, and what is left with everything accepted."""

    def figures() -> Named:
        yield "error-path", error_path_figure(f"{title}: error path", verdict.path)
        yield from _of_ranking(title, verdict.first_ranking)
        yield "structure", heatmap_figure(f"{title}: what is left", verdict.cells)
        plane = impact_plane(verdict.cleaned.data, verdict.fit)
        yield "rebound", plane_figure(f"{title}: rebound of the surface velocity", plane)

    write_figures(folder, figures())


def _of_ranking(title: str, ranking: Ranking) -> Named:
    yield (
        "ranking",
        ranking_figure(f"{title}: fall of chi-squared by score", ranking),
    )
    if sum(candidate.seen for candidate in ranking.candidates) > 1:
        yield "aliases", aliases_figure(f"{title}: effects that look alike", ranking)
