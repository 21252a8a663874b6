"""A sweep as the text of its file."""

from __future__ import annotations

import json
from pathlib import Path

from rigctl.errors import StoreError
from rigctl.sweeps.form import Sweep


def sweep_text(sweep: Sweep) -> str:
    """Return TOML that reads back as the same sweep; what is at its default is left out.

    Text and numbers are written as JSON has them: for these TOML reads the same.
    """
    document = sweep.model_dump(mode="json", exclude_defaults=True)
    grid, shots = document.pop("grid", None), document.pop("shots", [])
    sections = ["\n".join(_lines(document))] if document else []
    if grid is not None:
        sections.append("\n".join(["[grid]", *_lines(grid)]))
    sections += ["\n".join(["[[shots]]", *_lines(shot)]) for shot in shots]
    return "\n\n".join(sections) + "\n"


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


def _lines(fields: dict[str, object]) -> list[str]:
    return [f"{name} = {_value(value)}" for name, value in fields.items() if value is not None]


def _value(value: object) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(_lines(value)) + " }"
    # A JSON string may hold DEL as it is; TOML forbids it.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
