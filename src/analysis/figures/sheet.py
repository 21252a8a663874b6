"""What all pictures of the model share: paper, axes, and how they are written."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, Literal

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from analysis.figures.palette import FAILS, GREY, MEASURED

DPI = 150
FAINT = "#E4E4E4"
BAR_ROOM = 1.15
"""Beside matrices for their colour bar, inches."""
LETTER, SLANT = 0.074, 0.75
"""Width of a letter of the names, inches, and what 45 degrees leave of it."""
STRUCTURE = LinearSegmentedColormap.from_list("structure", ["#FFFFFF", "#F7D9C4", FAILS, "#7A3300"])
ALIKE = LinearSegmentedColormap.from_list("alike", ["#FFFFFF", "#BBD9EE", MEASURED, "#003A5D"])


class ShownAxes(Axes):
    """Axes that a notebook shows as the picture they are part of."""

    def _repr_png_(self) -> bytes | None:
        figure = self.get_figure(root=True)
        return None if figure is None else png(figure)


class Sheet(Figure):
    """A figure that a notebook shows, and whose axes it shows likewise; no window is opened."""

    def add_subplot(self, *args: Any, **named: Any) -> Axes:  # noqa: ANN401 - as Matplotlib has it
        """Add axes as Matplotlib's figure does."""
        axes: Axes = super().add_subplot(*args, **{"axes_class": ShownAxes, **named})
        return axes

    def add_axes(self, *args: Any, **named: Any) -> Axes:  # noqa: ANN401 - as Matplotlib has it
        """Add axes as Matplotlib's figure does."""
        axes: Axes = super().add_axes(*args, **{"axes_class": ShownAxes, **named})
        return axes

    def _repr_png_(self) -> bytes:
        return png(self)


def png(figure: Figure) -> bytes:
    """Return a figure as a PNG file."""
    content = BytesIO()
    figure.savefig(content, format="png")
    return content.getvalue()


def blank(width: float, height: float, layout: ConstrainedLayoutEngine | None = None) -> Figure:
    """Return an empty figure, inches."""
    figure = Sheet(figsize=(width, height), dpi=DPI, layout=layout)
    FigureCanvasAgg(figure)
    return figure


def sheet(width: float, height: float, title: str, note: str = "") -> Figure:
    """Return a figure, inches, that places its axes by itself below title and explanation."""
    top = heading_height(note)
    figure = blank(width, height, ConstrainedLayoutEngine(rect=(0.0, 0.0, 1.0, 1.0 - top / height)))
    head(figure, title, note)
    return figure


def heading_height(note: str) -> float:
    """Return what title and explanation take from the top, inches."""
    return 0.42 + (0.19 * (note.count("\n") + 1) if note else 0.0)


def head(figure: Figure, title: str, note: str) -> None:
    """Write the title and lines of explanation into the upper left corner."""
    width, height = figure.get_size_inches()
    name = figure.text(
        0.12 / width, 1 - 0.12 / height, title, fontsize=13, fontweight="bold", va="top"
    )
    wide = name.get_window_extent().width / figure.dpi
    name.set_fontsize(13 * min(1.0, (width - 0.3) / wide))
    figure.text(
        0.12 / width, 1 - 0.4 / height, note, fontsize=9, color=GREY, va="top", linespacing=1.4
    )


@dataclass(frozen=True, slots=True)
class Block:
    """A matrix to be drawn: its heading, and the names of its rows and columns."""

    heading: str
    rows: tuple[str, ...]
    columns: tuple[str, ...]

    @property
    def room(self) -> float:
        """Room for the names of the rows, inches."""
        slanted = SLANT * max(map(len, self.columns), default=0)
        return 0.35 + LETTER * max([slanted, *map(len, self.rows)])

    @property
    def below(self) -> float:
        """Room for the names of the columns, inches; they stand at 45 degrees."""
        return 0.3 + SLANT * LETTER * max(map(len, self.columns), default=0)


def blocks_sheet(
    title: str, note: str, blocks: Sequence[Block], *, cell: float
) -> tuple[Figure, list[Axes], Axes]:
    """Return a figure with matrices side by side, every cell a square of `cell` inches.

    Returns
    -------
    The figure, the axes of each block, and the axes of a colour bar under the lowest block.
    """
    rows = max(len(block.rows) for block in blocks)
    width = sum(block.room + cell * len(block.columns) for block in blocks) + BAR_ROOM
    top = heading_height(note) + 0.3
    height = top + cell * rows + max(block.below for block in blocks)
    width = max(width, 7.4)
    figure = blank(width, height)
    head(figure, title, note)
    left, parts = 0.0, []
    for block in blocks:
        left += block.room
        wide, tall = cell * len(block.columns), cell * len(block.rows)
        place = (left / width, 1 - (top + tall) / height, wide / width, tall / height)
        parts.append(_matrix(figure.add_axes(place), block))
        left += wide
    bar = (left + 0.3) / width, 1 - (top + cell * rows) / height
    return figure, parts, figure.add_axes((*bar, 0.14 / width, min(1.7, cell * rows) / height))


def _matrix(axes: Axes, block: Block) -> Axes:
    rows, columns = len(block.rows), len(block.columns)
    axes.set_xlim(-0.5, columns - 0.5)
    axes.set_ylim(rows - 0.5, -0.5)
    axes.set_xticks(range(columns), block.columns, rotation=45, ha="right", rotation_mode="anchor")
    axes.set_yticks(range(rows), block.rows)
    axes.tick_params(which="both", length=0, labelsize=9)
    axes.spines[:].set_visible(False)
    axes.set_title(block.heading, loc="left", fontsize=10, color=GREY)
    return axes


def plain(axes: Axes, grid: Literal["x", "y", "both"] = "y") -> None:
    """Leave only what is read: two axes and a faint grid behind the data."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(GREY)
    axes.tick_params(colors="#333333", labelsize=9)
    axes.set_axisbelow(True)
    axes.grid(axis=grid, color=FAINT, linewidth=0.8)


def write(figure: Figure, folder: Path, name: str) -> list[Path]:
    """Write a figure as PNG and SVG, the same bytes for the same figure; return the paths.

    Raises
    ------
    OSError
        The folder cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{name}.png", folder / f"{name}.svg"]
    with mpl.rc_context({"svg.hashsalt": name, "svg.fonttype": "none"}):
        figure.savefig(paths[0])
        figure.savefig(paths[1], metadata={"Date": None})
    return paths
