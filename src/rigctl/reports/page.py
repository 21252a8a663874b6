"""The report as one HTML file: figures inline, nothing loaded from anywhere, light and dark."""

from __future__ import annotations

import io
import math
import platform
import re
import shlex
from collections.abc import Mapping
from html import escape
from importlib.metadata import version
from importlib.resources import files

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from analysis.effects.contact.lasting_contact import EFFECT as LASTING
from analysis.effects.effect import Parameter
from analysis.figures.palette import FAILS, FLOOR, GREY, MEASURED
from analysis.figures.sheet import FAINT
from analysis.quantity import Quantity
from analysis.results.campaign import Results
from analysis.results.drawing import plane_figure, residual_figure, restitution_figure
from analysis.results.impacts import V_N, V_N_AFTER, V_S, V_S_AFTER
from analysis.results.published import THESIS
from analysis.results.ratios import Ratio
from analysis.results.tables import Table, tables
from rigctl.reports.html import download, paragraph, picture, section, table
from rigctl.reports.source import Source

WHERE = (
    " Run them in the folder in which the daemon was started; if that was not with the simulated "
    "rig, give report --config and the file whose SHA-256 stands under configuration."
)
LIBRARIES = ("numpy", "scipy", "matplotlib")


def reproduce(source: Source) -> str:
    """Return the section that says how to get the same numbers again."""
    origin = shlex.quote(source.origin)
    commands = (
        f"rigctl report {origin} --out report.html --csv tables",
        f"rigctl model fit {origin}",
    )
    programs = [("rigctl", version("rigctl")), ("Python", platform.python_version())]
    programs += [(name, version(name)) for name in LIBRARIES]
    lines = escape("\n".join(commands))
    return section(
        "Reproduce it",
        f'<pre tabindex="0">{lines}</pre>',
        paragraph(
            "The first makes this file anew, byte for byte, with the same program, libraries and "
            "measurements, and writes the table behind every figure; the second prints the fit to "
            "all that was measured." + (WHERE if source.stored else ""),
            "aside",
        ),
        table(("program", "version"), programs, "words"),
        "<h3>Files behind the numbers</h3>",
        table(("file", "SHA-256"), source.files, "words hash"),
    )


SLIDES = 0.5
"""A coefficient of friction is given for shots that more likely slid than stuck."""


def every_shot(found: Results, columns: dict[str, Table]) -> str:
    """Return the table of all shots' coefficients, errors in brackets."""
    impacts, each, slides = found.impacts, found.ratios, found.lines.held.slides
    rows = []
    for k, shot in enumerate(impacts.shots):
        slid = bool(slides[k] > SLIDES)
        rows.append(
            [
                int(shot),
                *(_velocity(found, k, column) for column in (V_N, V_S, V_N_AFTER, V_S_AFTER)),
                _ratio(each.e, k),
                _ratio(each.beta, k),
                _ratio(each.f, k) if slid else "–",
                "–" if math.isnan(slides[k]) else f"{slides[k]:.2f}",
            ]
        )
    headings = (
        *("shot", "vₙ, m/s", "vₛ, m/s", "vₙ′, m/s", "vₛ′, m/s"),
        *("e", "β", "f where it slides", "probability of sliding"),
    )
    note = (
        "vₙ is negative before contact, vₛ a length, vₛ′ its component along the incident "
        "direction. β = −vₛ′/vₛ. f is the impulse across over that along the normal, μ where the "
        "contact slides. The file has all errors with their correlations."
    )
    link = f'<p class="download aside">{download("coefficients", columns["coefficients"])}</p>'
    body = table(headings, rows)
    return section("Coefficients of every shot", body, paragraph(note, "aside"), link)


def missing_shots(source: Source, found: Results) -> str:
    """Return the table of shots that nothing was made of, each with its reason."""
    left_out = sorted([*source.missing, *found.left_out, *found.far], key=lambda one: one.shot)
    if not left_out:
        return section("Shots left out", paragraph("None: every shot was measured and used."))
    rows = [(one.shot, one.reason) for one in left_out]
    return section("Shots left out", table(("shot", "reason"), rows, "words"))


def _velocity(found: Results, k: int, column: int) -> str:
    value = float(found.impacts.velocities[k, column])
    sigma = math.sqrt(max(float(found.impacts.covariance[k, column, column]), 0.0))
    return "–" if math.isnan(value) else Quantity(value, sigma, "m/s").concise()


def _ratio(ratio: Ratio, k: int) -> str:
    value, sigma = float(ratio.value[k]), float(ratio.sigma[k])
    return "–" if math.isnan(value) else Quantity(value, sigma, "1").concise()


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


SYMBOLS = {"e": "e", "mu": "μ", "beta0": "β₀"}
NO_LAW = "no law of these contacts"
BEYOND_CHANCE = 25.0
"""χ² by degree of freedom from which on it says less than how far the shots lie from the lines."""
LEAST_CHANCE = 1e-99
"""Less is not told apart."""
MEANINGS = {"e": "normal restitution", "mu": "sliding friction", "beta0": "rotational restitution"}


def page(source: Source, found: Results) -> str:
    """Return the report of a campaign; the same measurements give the same text."""
    columns = tables(found)
    style = files("rigctl.reports").joinpath("style.css").read_text(encoding="utf-8")
    parts = (
        _head(source, found),
        _coefficients(source, found, columns),
        _rebound(found, columns),
        _restitution(found, columns),
        _residuals(found, columns),
        every_shot(found, columns),
        missing_shots(source, found),
        _apparatus(source),
        reproduce(source),
    )
    return (
        '<!doctype html>\n<html lang="en">\n<head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(source.title)}: results</title>\n<style>\n{style}</style></head>\n"
        f"<body>\n<main>\n{chr(10).join(parts)}\n</main>\n</body></html>\n"
    )


def _head(source: Source, found: Results) -> str:
    mark = '<span class="simulated">simulated</span>' if source.simulated else ""
    used = len(found.impacts.shots)
    counted = f"Collisions of two spheres: {used} of {source.listed} shots"
    if source.data.bodies[1].is_plate:
        counted = f"A sphere on a plate: {used} bounces of {source.listed} shots"
    lines = [
        f"<h1>{escape(source.title)}{mark}</h1>",
        paragraph(
            f"{counted} measured and used. Errors are standard errors; 0.7401(2) is "
            "0.7401 ± 0.0002.",
            "aside",
        ),
        '<div class="key">',
    ]
    for name, meaning in MEANINGS.items():
        shown, how = NO_LAW if found.lasting else "not determined", ""
        if (best := _best(found, name)) is not None:
            shown, how = best[0].concise(), f"; {best[1]}"
        lines.append(
            f"<div><b>{escape(shown)}</b><span>{SYMBOLS[name]}, {meaning}{how}</span></div>"
        )
    return "\n".join([*lines, "</div>"])


def _best(found: Results, name: str) -> tuple[Quantity, str] | None:
    """Return the better estimate; where contacts last the two lines are no law of theirs."""
    lines = None if found.lasting else found.coefficients().get(name)
    return better(found.whole_fit.get(name), lines)


def better(whole: Quantity | None, lines: Quantity | None) -> tuple[Quantity, str] | None:
    """Return the estimate with the smaller standard error, and which of the two it is.

    None where neither is determined.
    """
    named = ((whole, "fit to all that was measured"), (lines, "two lines, by regression"))
    told = [(own, how) for own, how in named if own is not None and own.determined]
    return min(told, key=lambda one: one[0].sigma, default=None)


def _coefficients(source: Source, found: Results, columns: dict[str, Table]) -> str:
    regression, whole = found.coefficients(), found.whole_fit
    absent = NO_LAW if found.lasting else "–"
    rows = [
        [
            f"{SYMBOLS[name]}, {meaning}" + (", mean" if found.lasting and name == "e" else ""),
            _shown(regression.get(name), absent),
            _shown(whole.get(name), absent),
            f"{THESIS[name]:.2f}",
            _pull(regression.get(name), THESIS[name]),
        ]
        for name, meaning in MEANINGS.items()
    ]
    if found.lasting:
        rows += [
            [f"{q.symbol}, {q.meaning}", "–", _of_contact(whole, q), "–", "–"]
            for q in LASTING.parameters
        ]
    headings = (
        "coefficient",
        "two lines, by regression",
        "contact that lasts, fit to all that was measured"
        if found.lasting
        else "fit to all that was measured",
        "thesis, nylon",
        "regression less thesis",
    )
    remark = _remark(source, found)
    said = [
        paragraph(remark),
        *(paragraph(f"Fit to all that was measured: {text}.") for text in found.remarks),
    ]
    missing = [SYMBOLS[name] for name in MEANINGS if name not in regression]
    if missing and not found.lasting:
        said.append(paragraph(f"Not determined by these shots: {', '.join(missing)}."))
    lines = found.lines
    if bool(found.impacts.surface.any()) and not np.isfinite(lines.held.slides).any():
        said.append(paragraph("They lie too close together to tell whether they stuck or slid."))
    link = f'<p class="download aside">{download("parameters", columns["parameters"])}</p>'
    return section("Coefficients", table(headings, rows), *said, link)


def _remark(source: Source, found: Results) -> str:
    lines = found.lines
    told = (
        f"Regression: χ² = {lines.chi2:.1f} for {lines.freedom} degrees of freedom, "
        f"p {_chance(lines.p_value)}."
    )
    if lines.chi2 > BEYOND_CHANCE * lines.freedom:
        times = np.sqrt(lines.chi2 / lines.freedom)
        told = f"The shots lie {times:.0f} times as far from the two lines as their errors say."
    if found.lasting:
        return (
            f"{told} The contacts last, and the two lines are no law of theirs: e falls with the "
            "obliquity, and μ and β₀ of the lines are no constants. e of the regression is the "
            "mean of these shots, with the error of their measurement."
        )
    if lines.scatter > 1:
        told += (
            f" The shots scatter {lines.scatter:.2f} times as much as their errors say; the errors "
            "of the regression are enlarged by that. The hard-sphere operator may lack an effect: "
            f"rigctl model explain {source.origin}"
        )
    return told


def _of_contact(whole: Mapping[str, Quantity], parameter: Parameter) -> str:
    quantity = whole[f"{LASTING.name}.{parameter.symbol}"]
    unit = "" if quantity.unit == "1" or not quantity.determined else f" {quantity.unit}"
    return quantity.concise() + unit


def _chance(p: float) -> str:
    return f"= {p:.2g}" if p > LEAST_CHANCE else f"< {LEAST_CHANCE:g}"


def _shown(quantity: Quantity | None, absent: str) -> str:
    return absent if quantity is None else quantity.concise()


def _pull(quantity: Quantity | None, published: float) -> str:
    return "–" if quantity is None else f"{quantity.value - published:+.4f}"


def _rebound(found: Results, columns: dict[str, Table]) -> str:
    svg = inline_svg(
        plane_figure(found),
        "plane",
        "surface velocity after contact against that before, both over the approach speed, with "
        "the two lines and the curve of Maw, Barber and Fawcett",
    )
    caption = (
        "Figure 7.4: rebound of the surface velocity; left where the lines meet, right all shots. "
        "Bars are standard errors in both coordinates; their correlation is in the table."
    )
    links = [download(name, columns[name]) for name in ("figure-7-4", "figure-7-4-curves")]
    return section("Rebound of the surface velocity", picture(svg, caption, links))


def _restitution(found: Results, columns: dict[str, Table]) -> str:
    svg = inline_svg(
        restitution_figure(found), "restitution", "normal restitution against approach speed"
    )
    caption = "Figure 3.1c: restitution of every shot against its approach speed."
    line = found.speed
    if line is not None:
        slope = Quantity(line.slope, float(line.covariance[0, 0]) ** 0.5, "s/m")
        share = abs(slope.value) / slope.sigma
        caption += (
            f" A line has the slope {slope.concise()} for each m/s, {share:.1f} standard errors "
            f"from zero (χ² = {line.chi2:.1f} for {line.freedom} degrees of freedom)."
        )
    return section(
        "Restitution against approach speed",
        picture(svg, caption, [download("restitution", columns["restitution"])]),
    )


def _residuals(found: Results, columns: dict[str, Table]) -> str:
    svg = inline_svg(
        residual_figure(found), "residuals", "residuals of the regression in standard errors"
    )
    caption = (
        "Distance of every shot from the regression in its standard errors, bands at 1 and 3: "
        "left vₙ′ + e vₙ, right vₛ′ less the line of its regime. Structure here is physics "
        "that the two lines lack."
    )
    return section(
        "Residuals of the regression",
        picture(svg, caption, [download("residuals", columns["residuals"])]),
    )


def _apparatus(source: Source) -> str:
    parts = [
        f"<div><h3>{escape(facts.heading.replace('_', ' '))}</h3>"
        + table((), facts.rows, "words")
        + "</div>"
        for facts in source.facts
        if facts.rows
    ]
    return section("Apparatus and settings", '<div class="columns">' + "\n".join(parts) + "</div>")
