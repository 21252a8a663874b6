"""Where it fails: every quantity against everything it may depend on, as a heat map."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Rectangle

from analysis.figures.sheet import STRUCTURE, Block, blocks_sheet
from analysis.model.structure.findings import ALWAYS
from analysis.model.structure.lackoffit import Cell
from analysis.model.structure.layout import ALARM, BRIGHTEST, columns_of, rows_of, short_label

SIZE = 0.34
"""Of a cell, inches."""


def heatmap_figure(title: str, cells: Sequence[Cell]) -> Figure:
    """Draw all cells in three blocks: contact, flight, camera."""
    parts = {
        "jump at contact": [c for c in cells if c.covariate != "time" and not _camera(c)],
        "flight": [c for c in cells if c.covariate == "time"],
        "camera": [c for c in cells if _camera(c)],
    }
    note = (
        "always: mean of the row, in its standard errors; else standard deviations by which smooth "
        "functions of a covariate lower χ²\nbeyond chance, that mean taken out; framed: less than "
        "1 % chance with all cells looked at.\nn: along the normal; t: along the incident surface "
        "velocity; b: across both; common: mean of a and b; relative: b less a."
    )
    blocks = [
        Block(name, _rows(own), tuple(map(short_label, _columns(own))))
        for name, own in parts.items()
    ]
    figure, axes, bar = blocks_sheet(title, note, blocks, cell=SIZE)
    brightest = max(BRIGHTEST, *(max(c.course_deviation, c.mean_deviation) for c in cells))
    for own, part in zip(parts.values(), axes, strict=True):
        image = _block(part, own, brightest)
    legend = figure.colorbar(image, cax=bar)
    legend.set_label("standard deviations", fontsize=9)
    legend.ax.tick_params(labelsize=9, length=0)
    legend.outline.set_visible(False)
    return figure


def _camera(cell: Cell) -> bool:
    return cell.channel.startswith("image ")


def _rows(cells: Sequence[Cell]) -> tuple[str, ...]:
    return tuple(rows_of(cell.channel for cell in cells))


def _block(axes: Axes, cells: Sequence[Cell], brightest: float) -> AxesImage:
    rows, columns = _rows(cells), _columns(cells)
    values = np.zeros((len(rows), len(columns)))
    for cell in cells:
        row = rows.index(cell.channel)
        shown = [(cell.covariate, cell.course_deviation, cell.course_p_holm)]
        if cell.mean_freedom:
            shown.append((ALWAYS, cell.mean_deviation, cell.mean_p_holm))
        for covariate, value, chance in shown:
            column = columns.index(covariate)
            if not values[row, column]:
                _number(axes, (column, row), value, bright=value > 0.6 * brightest)
                if chance < ALARM:
                    _frame(axes, (column, row))
            values[row, column] = value
    axes.vlines(np.arange(1, len(columns)) - 0.5, -0.5, len(rows) - 0.5, color="white", linewidth=2)
    axes.hlines(np.arange(1, len(rows)) - 0.5, -0.5, len(columns) - 0.5, color="white", linewidth=2)
    return axes.imshow(values, cmap=STRUCTURE, vmin=0, vmax=brightest, aspect="auto")


def _columns(cells: Sequence[Cell]) -> tuple[str, ...]:
    """Return the covariates, the mean of each row first."""
    means = [ALWAYS] if any(cell.mean_freedom for cell in cells) else []
    return tuple(columns_of([*means, *(cell.covariate for cell in cells)]))


def _number(axes: Axes, place: tuple[int, int], value: float, *, bright: bool) -> None:
    colour = "white" if bright else "#222222"
    axes.text(*place, f"{value:.0f}", ha="center", va="center", color=colour, size=8)


def _frame(axes: Axes, place: tuple[int, int]) -> None:
    corner = (place[0] - 0.45, place[1] - 0.45)
    axes.add_patch(Rectangle(corner, 0.9, 0.9, fill=False, color="black", linewidth=1.3))
