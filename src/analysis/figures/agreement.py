"""The table of agreement as a picture: every quantity's error beside its noise."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from analysis.figures.palette import FAILS, FLOOR, GREY, MEASURED
from analysis.figures.sheet import FAINT, plain, sheet
from analysis.model.agreement.table import Agreement, Row, probability, three_digits

ALARM = 0.01
BARS = 2.0
"""Sampling errors that a bar reaches to each side."""
LARGE = 3.0
"""Beyond it, a linear axis would press everything else together."""
LINE = 0.235
"""Height of a line, inches."""


def agreement_figure(title: str, found: Agreement) -> Figure:
    """Draw the error of each quantity in units of its noise, with its numbers beside it."""
    lines: list[tuple[str, Row | None]] = []
    for stage in found.stages:
        lines.append((stage.name, None))
        lines.extend((row.quantity, row) for row in stage.rows)
    note = (
        "Error of the prediction over the noise, with two standard deviations; noise alone gives "
        "1. After contact each shot is predicted\nfrom its poses before contact, with parameters "
        "fitted to the other shots. Orange: p < 0.01 for noise alone."
    )
    figure = sheet(9.6, 1.6 + LINE * len(lines), title, note)
    axes, numbers = figure.subplots(1, 2, width_ratios=[1.0, 1.35], sharey=True)
    plain(axes, "x")
    axes.axvline(1.0, color=FLOOR, linewidth=1.6)
    for place, (_, row) in enumerate(lines):
        if row is None:
            continue
        colour = FAILS if row.p_holm < ALARM else MEASURED
        axes.errorbar(
            row.error, place, xerr=BARS * row.sampling, fmt="o", color=colour, markersize=5.5
        )
    axes.set_ylim(len(lines) - 0.4, -0.8)
    axes.set_yticks(range(len(lines)), [name for name, _ in lines])
    for label, (_, row) in zip(axes.get_yticklabels(), lines, strict=True):
        if row is None:
            label.set_fontweight("bold")
    axes.tick_params(axis="y", length=0)
    if max(row.error for row in found.rows) > LARGE:
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(LogLocator(10, subs=(1.0, 2.0, 5.0)))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xlabel("error / noise (1)")
    _numbers(numbers, lines)
    return figure


def _numbers(axes: Axes, lines: list[tuple[str, Row | None]]) -> None:
    axes.axis("off")
    axes.set_xlim(0.0, 1.0)
    columns = ((0.16, "χ²"), (0.31, "dof"), (0.49, "p"), (0.68, "error"), (0.84, "floor"))
    for place, heading in columns:
        axes.text(place, -0.75, heading, ha="right", va="center", fontsize=9, color=GREY)
    axes.text(0.88, -0.75, "unit", ha="left", va="center", fontsize=9, color=GREY)
    for line, (_, row) in enumerate(lines):
        if row is None:
            axes.axhline(line - 0.5, color=FAINT, linewidth=0.8)
            continue
        texts = (
            f"{row.chi2:.0f}",
            f"{row.freedom:.0f}",
            probability(row.p_holm),
            three_digits(row.size),
            three_digits(row.floor),
        )
        colour = FAILS if row.p_holm < ALARM else "#222222"
        for (place, _), text in zip(columns, texts, strict=True):
            axes.text(place, line, text, ha="right", va="center", fontsize=9, color=colour)
        axes.text(0.88, line, row.unit, ha="left", va="center", fontsize=9, color=GREY)
