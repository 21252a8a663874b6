"""A sweep as the text of its file."""

from __future__ import annotations

from pathlib import Path

from analysis.files import toml_text
from rigctl.errors import StoreError
from rigctl.sweeps.form import Sweep


def sweep_text(sweep: Sweep) -> str:
    """Return TOML that reads back as the same sweep; what is at its default is left out."""
    return toml_text(sweep.model_dump(mode="json", exclude_defaults=True))


def write_sweep(path: Path, sweep: Sweep) -> None:
    """Write a sweep file; one of that name is replaced.

    Raises
    ------
    StoreError
        It cannot be written.
    """
    try:
        path.write_text(sweep_text(sweep), encoding="utf-8")
    except OSError as error:
        raise StoreError(
            f"cannot be written: {error.strerror}",
            part=str(path),
            todo="name a file in a folder that exists",
        ) from error
