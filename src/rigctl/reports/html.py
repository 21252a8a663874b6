"""Small pieces of HTML; whatever is handed over as text is escaped here."""

from __future__ import annotations

import base64
import csv
import io
from collections.abc import Iterable, Sequence
from html import escape

Row = Sequence[object]


def paragraph(text: str, kind: str = "") -> str:
    """Return a paragraph of text."""
    return f"<p{_class(kind)}>{escape(text)}</p>"


def table(headings: Row, rows: Iterable[Row], kind: str = "") -> str:
    """Return a table of text; an empty row of headings leaves them out."""
    head = "".join(f"<th>{escape(str(cell))}</th>" for cell in headings)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in row) + "</tr>\n"
        for row in rows
    )
    top = f"<thead><tr>{head}</tr></thead>" if head else ""
    return f"<table{_class(kind)}>{top}<tbody>\n{body}</tbody></table>"


def section(heading: str, *parts: str) -> str:
    """Return a section whose parts are HTML; a wide one is scrolled, by keys as well."""
    said = escape(heading)
    inside = "\n".join((f"<h2>{said}</h2>", *parts))
    return f'<section tabindex="0" aria-label="{said}">{inside}\n</section>'


def picture(svg: str, caption: str, links: Sequence[str]) -> str:
    """Return a figure with a caption in text and links in HTML."""
    beside = f' <span class="download">{" · ".join(links)}</span>' if links else ""
    return f'<figure tabindex="0">{svg}<figcaption>{escape(caption)}{beside}</figcaption></figure>'


def download(name: str, rows: Iterable[Row]) -> str:
    """Return a link that saves a table as CSV; the table is in the link."""
    data = base64.b64encode(csv_text(rows).encode()).decode()
    file = f"{escape(name)}.csv"
    return f'<a download="{file}" href="data:text/csv;base64,{data}">{file}</a>'


def csv_text(rows: Iterable[Row]) -> str:
    """Return rows as CSV."""
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="\n").writerows(rows)
    return buffer.getvalue()


def _class(kind: str) -> str:
    return f' class="{escape(kind)}"' if kind else ""
