"""Why the first analysis on a machine is slow, said before it begins."""

from __future__ import annotations

import sys

from analysis.shot import Method
from rigctl.measuring.first_analysis import wait_for_compiler


def announce_compiling(method: Method) -> None:
    """Say on standard error that a method is compiled first, where it was not yet."""
    if (wait := wait_for_compiler(method)) is not None:
        print(  # noqa: T201
            f"rigctl: first {method} analysis here; compiling takes about {wait}, once "
            "(rigctl precompile does it beforehand)",
            file=sys.stderr,
        )
