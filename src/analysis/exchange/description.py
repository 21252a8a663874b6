"""campaign.toml: camera, spheres and surroundings of a campaign."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, Field, ValidationError

from analysis.errors import InputError
from analysis.exchange.faults import fault
from analysis.files import read_toml, toml_text
from analysis.schema.codec import STRICT
from analysis.setup import Setup, setup_document, setup_of

FORMAT = 1


class _Heading(BaseModel):
    model_config = STRICT
    format: int
    name: Annotated[str, Field(min_length=1)]


def read_description(path: Path) -> tuple[str, Setup]:
    """Read campaign.toml.

    Returns
    -------
    The campaign's name and its set-up.

    Raises
    ------
    InputError
        Absent, empty, not TOML, or written in a newer format; or every key that is unknown,
        missing, or out of its range.
    """
    table = read_toml(path)
    if not table:
        raise InputError(path, "is empty; it must describe camera and spheres")
    found = table.get("format", FORMAT)
    if found != FORMAT:
        raise InputError(path, f"format {found!r}; this program reads format {FORMAT}")
    faults: list[str] = []
    heading = {key: table.pop(key) for key in ("format", "name") if key in table}
    name, setup = "", None
    try:
        name = _Heading.model_validate(heading).name
    except ValidationError as error:
        faults += map(fault, error.errors())
    try:
        setup = setup_of(table)
    except ValidationError as error:
        faults += map(fault, error.errors())
    if setup is None or faults:
        raise InputError(path, "; ".join(faults))
    return name, setup


def description(name: str, setup: Setup) -> str:
    """Return campaign.toml, without fields that are not known."""
    document: dict[str, Any] = {"format": FORMAT, "name": name, **setup_document(setup)}
    # The exposure of each shot is in shots.csv.
    document["camera"].pop("exposure_s", None)
    return toml_text(document)
