"""remarks.toml: what people say of a campaign as a whole, its note and its tags."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import ErrorDetails

from analysis.errors import InputError
from analysis.files import parse_toml, read_toml, toml_text
from rigctl.plain_text import MOST_TAGS, Line, Tag
from rigctl.store.campaign_words import Words

REMARKS = "remarks.toml"


class _Remarks(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    note: Line | None = None
    tags: list[Tag] = Field(default_factory=list, max_length=MOST_TAGS)


def read_remarks(folder: Path) -> Words:
    """Return what a folder says of its campaign; nothing where it has no such file.

    Raises
    ------
    InputError
        The file is no TOML, or says what cannot be said of a campaign.
    """
    path = folder / REMARKS
    if not path.exists():
        return Words()
    try:
        return _words(read_toml(path))
    except ValidationError as error:
        raise InputError(path, "; ".join(map(_fault, error.errors()))) from error


def parsed(content: bytes) -> Words:
    """Return what the content of the file says; raise what is wrong with it."""
    return _words(parse_toml(Path(REMARKS), content))


def _words(table: dict[str, Any]) -> Words:
    found = _Remarks.model_validate(table)
    return Words(found.note, tuple(sorted(set(found.tags))))


def written(words: Words) -> bytes | None:
    """Return the file that says these words; None where there is nothing to say."""
    said = {"note": words.note, "tags": list(words.tags) or None}
    return toml_text(said).encode() if said != {"note": None, "tags": None} else None


def _fault(error: ErrorDetails) -> str:
    key = ".".join(map(str, error["loc"]))
    return f"{key}: {error['msg']} (found {error['input']!r})"
