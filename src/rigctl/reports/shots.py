"""The shots of a report, one by one: those that count and those that do not; what reproduces it."""

from __future__ import annotations

import math
import platform
import shlex
from html import escape
from importlib.metadata import version

from analysis.quantity import Quantity
from analysis.results.campaign import Results
from analysis.results.impacts import V_N, V_N_AFTER, V_S, V_S_AFTER
from analysis.results.ratios import Ratio
from analysis.results.tables import Table
from rigctl.reports.html import download, paragraph, section, table
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
        f"<pre>{lines}</pre>",
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
