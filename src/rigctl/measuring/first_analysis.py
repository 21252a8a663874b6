"""Why the first analysis on a machine is slow."""

from __future__ import annotations

from analysis.compiled import kept_on_disk
from analysis.shot import Method


def wait_for_compiler(method: Method) -> str | None:
    """Return how long a method is compiled before its next shot; None: it was compiled before."""
    # Loading compiled functions is slow.
    if method == "photometric":
        from analysis.photometric.method import compiles_first  # noqa: PLC0415

        return "80 s" if compiles_first() else None
    from analysis.imaging.marker.marker_curves import dark_ellipses  # noqa: PLC0415

    return None if kept_on_disk(dark_ellipses) else "40 s"
