"""What reproduces a report: program and libraries, commands, and the hashes of what was read."""

from __future__ import annotations

import platform
import shlex
from html import escape
from importlib.metadata import version

from rigctl.reports.html import paragraph, section, table
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
