"""A figure as SVG inside a page: it takes the page's colours of ink, light or dark."""

from __future__ import annotations

import io
import re

import matplotlib as mpl
from matplotlib.figure import Figure

from analysis.figures.palette import FAILS, FLOOR, GREY, MEASURED
from analysis.figures.sheet import FAINT

INKS = {
    "#000000": "currentColor",
    "#333333": "currentColor",
    GREY.lower(): "var(--muted)",
    FAINT.lower(): "var(--line)",
    MEASURED.lower(): "var(--blue)",
    FAILS.lower(): "var(--fails)",
    FLOOR.lower(): "var(--floor)",
}
"""Colours as drawn, and the page's names for them; what is not here keeps its own."""


def inline_svg(figure: Figure, name: str, description: str) -> str:
    """Return the figure as an SVG element, the same text for the same figure.

    Parameters
    ----------
    name
        Unique in the page: it stands before every identifier within.
    description
        For those who do not see it; plain text without markup.
    """
    buffer = io.StringIO()
    with mpl.rc_context({"svg.hashsalt": name, "svg.fonttype": "none"}):
        figure.savefig(buffer, format="svg", transparent=True, metadata={"Date": None})
    text = buffer.getvalue()
    text = text[text.index("<svg ") :]
    for drawn, shown in INKS.items():
        text = re.sub(drawn, shown, text, flags=re.IGNORECASE)
    text = re.sub(r'\bid="', f'id="{name}-', text)
    text = re.sub(r"url\(#", f"url(#{name}-", text)
    text = re.sub(r'xlink:href="#', f'xlink:href="#{name}-', text)
    text = re.sub(r"<metadata>.*?</metadata>", "", text, count=1, flags=re.DOTALL)
    return text.replace("<svg ", f'<svg role="img" aria-label="{description}" ', 1)
