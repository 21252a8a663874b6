"""remarks.toml: note and tags of a campaign as a whole."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import ErrorDetails

from analysis.errors import InputError
from analysis.files import parse_toml, read_toml, toml_text
from rigctl.plain_text import MOST_TAGS, Line, Tag
from rigctl.store.campaign_remarks import Remarks

REMARKS = "remarks.toml"


class _Remarks(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    note: Line | None = None
    tags: list[Tag] = Field(default_factory=list, max_length=MOST_TAGS)


def read_remarks(folder: Path) -> Remarks:
    """Return the remarks in a folder; empty where it has no such file.

    Raises
    ------
    InputError
        The file is no TOML, or its remarks are not valid.
    """
    path = folder / REMARKS
    if not path.exists():
        return Remarks()
    try:
        return _words(read_toml(path))
    except ValidationError as error:
        raise InputError(path, "; ".join(map(_fault, error.errors()))) from error


def parsed(content: bytes) -> Remarks:
    """Return the remarks in the content of the file; raise its faults."""
    return _words(parse_toml(Path(REMARKS), content))


def _words(table: dict[str, Any]) -> Remarks:
    found = _Remarks.model_validate(table)
    return Remarks(found.note, tuple(sorted(set(found.tags))))


def written(remarks: Remarks) -> bytes | None:
    """Return the content of the file; None without remarks."""
    table = {"note": remarks.note, "tags": list(remarks.tags) or None}
    return toml_text(table).encode() if table != {"note": None, "tags": None} else None


def _fault(error: ErrorDetails) -> str:
    key = ".".join(map(str, error["loc"]))
    return f"{key}: {error['msg']} (found {error['input']!r})"
