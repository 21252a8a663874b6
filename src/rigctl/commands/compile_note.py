"""Why the first analysis on a machine is slow, said before it begins."""

from __future__ import annotations

import sys

from analysis.compiled import kept_on_disk
from analysis.shot import Method


def announce_compiling(method: Method) -> None:
    """Say on standard error that a method is compiled first, where it was not yet."""
    # Compiled functions are loaded only where they are wanted.
    if method == "photometric":
        from analysis.photometric.method import compiles_first  # noqa: PLC0415

        first, wait = compiles_first(), "80 s"
    else:
        from analysis.imaging.marker_curves import dark_ellipses  # noqa: PLC0415

        first, wait = not kept_on_disk(dark_ellipses), "40 s"
    if first:
        print(  # noqa: T201
            f"rigctl: first {method} analysis here; compiling takes about {wait}, once "
            "(rigctl precompile does it beforehand)",
            file=sys.stderr,
        )
