"""Tables of numbers: aligned, with units, explained on hover."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

from nicegui import ui

from rigctl.page.parts.quantities import Quantity

NOTHING = "–"
LEAST_EXPONENT, MOST_EXPONENT = -6, 2
INDEX = re.compile(r"\bv_([ns])\b")
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True, slots=True)
class Cell:
    """Text of a cell, its text on hover, and its style class."""

    text: str
    hover: str = ""
    look: str = ""


@dataclass(frozen=True, slots=True)
class Line:
    """A line of cells with a style class; a single cell spans the table."""

    cells: Sequence[Cell | str]
    look: str = ""


def facts(headings: Sequence[Cell | str], lines: Iterable[Line], testid: str = "") -> ui.html:
    """Place a table; whatever text comes in is escaped."""
    html = facts_html(headings, lines)
    return ui.html(html, sanitize=False).classes("wide").props(f"data-testid={testid or 'facts'}")


def facts_html(headings: Sequence[Cell | str], lines: Iterable[Line]) -> str:
    """Return the table as HTML."""
    head = "".join(_cell("th", cell) for cell in headings)
    width = max(len(headings), 1)
    body = "".join(_line(line, width) for line in lines)
    return f'<table class="facts"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'


def _line(line: Line, width: int) -> str:
    span = width if len(line.cells) == 1 else 1
    cells = "".join(_cell("td", cell, span) for cell in line.cells)
    return f'<tr class="{escape(line.look)}">{cells}</tr>'


def _cell(tag: str, cell: Cell | str, span: int = 1) -> str:
    own = Cell(cell) if isinstance(cell, str) else cell
    if not own.text:
        tag = "td"  # A heading without words is none.
    parts = [f' class="{escape(own.look)}"'] if own.look else []
    parts += [f' colspan="{span}"'] if span > 1 else []
    text = lowered(escape(own.text))
    if own.hover:
        text = f'<span title="{escape(own.hover)}">{text}</span>'
    return f"<{tag}{''.join(parts)}>{text}</{tag}>"


def lowered(html: str) -> str:
    """Return HTML with the index of a speed, v_n or v_s, set as one."""
    return INDEX.sub(r"v<sub>\1</sub>", html)


def measured(about: Quantity, value: Mapping[str, Any] | None, look: str = "") -> Line:
    """Return a line with a quantity, its value with its standard error, and its unit."""
    name = Cell(about.name, about.meaning)
    if value is None:
        return Line([name, NOTHING, about.unit], look)
    return Line([name, with_error(value, about.per_si), Cell(about.unit, look="left dim")], look)


def with_error(value: Mapping[str, Any], factor: float = 1.0) -> str:
    """Return a value times a factor as `12.34 ± 0.05`, with the places that the error allows.

    What is null was not determined.
    """
    if value["value"] is None:
        return "not determined"
    number, sigma = factor * float(value["value"]), value.get("sigma")
    sigma = None if sigma is None else abs(factor) * sigma
    if sigma is None or not sigma > 0:
        return f"{number:.4g}"
    exponent = math.floor(math.log10(sigma))
    if not LEAST_EXPONENT <= exponent <= MOST_EXPONENT:
        return minus(f"{number:.3g} ± {sigma:.1g}")
    places = max(0, 1 - exponent)
    return minus(f"{number:.{places}f} ± {sigma:.{places}f}")


def minus(text: str) -> str:
    """Return a number's text with a true minus sign."""
    return text.replace("-", "−")


def chance(p: float) -> str:
    """Return a probability, the smallest ones as a power of ten."""
    if p >= 0.001:
        return f"{p:.2g}" if p < 0.1 else f"{p:.2f}"
    return "< 10" + str(math.ceil(math.log10(max(p, 1e-300)))).translate(RAISED)
