"""Scores of effects that are not in the fit, and their alias sets."""

from __future__ import annotations

import re
from string import ascii_uppercase

import numpy as np
from matplotlib.figure import Figure

from analysis.figures.palette import GREY, MEASURED
from analysis.figures.sheet import ALIKE, Block, blocks_sheet, plain, sheet
from analysis.model.rank.candidate import Candidate, Ranking
from analysis.model.verdict.documents import SHOWN_ALIAS
from analysis.quantity import Quantity

MOST = 15
DOUBTED = "#C9C9C9"
HEADINGS = ((0.1, "score", "right"), (0.18, "alike", "center"), (0.26, "amplitude", "left"))


def ranking_figure(title: str, ranking: Ranking) -> Figure:
    """Draw the scores of the most promising candidates with amplitudes and alias groups."""
    shown = _shown(ranking)
    groups = alias_groups(ranking)
    note = (
        "Score: root of the expected drop of χ². Effects with one letter are not "
        f"told apart by\nthese shots (correlations above {SHOWN_ALIAS:g}). Grey: an amplitude "
        "outside the plausible range."
    )
    figure = sheet(9.2, 1.9 + 0.28 * max(len(shown), 2), title, note)
    axes, texts = figure.subplots(1, 2, width_ratios=[1.0, 1.05], sharey=True)
    plain(axes, "x")
    scores = [float(np.sqrt(c.delta_chi2)) for c in shown]
    colours = [MEASURED if c.plausible else DOUBTED for c in shown]
    axes.barh(range(len(shown)), scores, color=colours, height=0.66)
    texts.axis("off")
    for place, heading, side in HEADINGS:
        texts.text(place, -0.8, heading, fontsize=9, color=GREY, va="center", ha=side)
    for k, candidate in enumerate(shown):
        letter = groups.get(candidate.effect.name, "")
        texts.text(0.1, k, f"{scores[k]:.1f}", va="center", ha="right", fontsize=9)
        texts.text(0.18, k, letter, va="center", ha="center", fontsize=9, fontweight="bold")
        colour = "#222222" if candidate.plausible else GREY
        texts.text(0.26, k, _amplitude(candidate), va="center", fontsize=9, color=colour)
    axes.set_yticks(range(len(shown)), [c.effect.name for c in shown])
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(max(len(shown), 1) - 0.4, -1.0)
    axes.set_xlabel("score (standard deviations)")
    return figure


def aliases_figure(title: str, ranking: Ranking) -> Figure:
    """Draw the matrix of correlations between what the candidates do to the residuals."""
    shown = _shown(ranking)
    count = len(shown)
    note = (
        "Largest correlation between what two effects do to the poses, with all that is fitted\n"
        "projected out, in the order of the scores. Near 1 these shots cannot tell them apart."
    )
    names = tuple(c.effect.name for c in shown)
    block = Block("", names, names)
    figure, [axes], bar = blocks_sheet(title, note, [block], cell=0.38)
    values = ranking.aliases[:count, :count]
    for i, j in np.ndindex(count, count):
        if i != j:
            colour = "white" if values[i, j] > 0.6 else "#222222"
            text = "1" if values[i, j] > 0.995 else f"{values[i, j]:.2f}".removeprefix("0")
            axes.text(j, i, text, ha="center", va="center", fontsize=8, color=colour)
    edges = np.arange(1, count) - 0.5
    axes.vlines(edges, -0.5, count - 0.5, color="white", linewidth=1.5)
    axes.hlines(edges, -0.5, count - 0.5, color="white", linewidth=1.5)
    image = axes.imshow(values, cmap=ALIKE, vmin=0.0, vmax=1.0, aspect="auto")
    legend = figure.colorbar(image, cax=bar)
    legend.set_label("correlation (1)", fontsize=9)
    legend.ax.tick_params(labelsize=9, length=0)
    legend.outline.set_visible(False)
    return figure


def alias_groups(ranking: Ranking) -> dict[str, str]:
    """Return a letter for each shown effect that has company, the same for all of a group.

    In a group each looks like each other one; an effect joins the first group that it fits.
    """
    shown = _shown(ranking)
    alike = ranking.aliases > SHOWN_ALIAS
    groups: list[list[int]] = []
    for k in range(len(shown)):
        fitting = (group for group in groups if alike[k, group].all())
        group = next(fitting, None)
        if group is None:
            groups.append([k])
        else:
            group.append(k)
    company = [group for group in groups if len(group) > 1]
    return {
        shown[k].effect.name: letter
        for letter, group in zip(ascii_uppercase, company, strict=False)
        for k in group
    }


def _shown(ranking: Ranking) -> list[Candidate]:
    return [c for c in ranking.candidates if c.seen][:MOST]


def _amplitude(candidate: Candidate) -> str:
    texts = []
    for parameter, value, sigma in zip(
        candidate.effect.parameters, candidate.amplitudes, candidate.sigmas, strict=True
    ):
        unit = "" if parameter.unit == "1" else f" {_raised(parameter.unit)}"
        quantity = Quantity(float(value), float(sigma), parameter.unit)
        texts.append(f"{parameter.symbol} = {quantity.concise()}{unit}")
    return ", ".join(texts[:2]) + (", ..." if len(texts) > 2 else "")


def _raised(unit: str) -> str:
    """Return a unit with its powers set as such."""
    return re.sub(r"\^(-?[\d.]+)", r"$^{\1}$", unit)
