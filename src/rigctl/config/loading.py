"""From a TOML file to a checked configuration, or to one sentence that says what is wrong."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from analysis import files
from analysis.errors import InputError
from rigctl.config.configuration import Configuration
from rigctl.errors import ConfigurationError
from rigctl.shipped import shipped
from rigctl.units import RATIO, unit_of

Model = TypeVar("Model", bound=BaseModel)

_UNKNOWN = {"extra_forbidden", "unexpected_keyword_argument"}
_BOUNDS = {
    "gt": "more than {}",
    "ge": "at least {}",
    "lt": "less than {}",
    "le": "at most {}",
    "min_length": "at least {} entries or characters",
    "max_length": "at most {} entries or characters",
    "pattern": "text like {}",
    "expected": "{}",
    "expected_tags": "one of {}",
}


def default_path() -> Path:
    """Return the simulated rig's file: beside the package when installed, else the checkout's.

    Raises
    ------
    ConfigurationError
        Neither is there.
    """
    todo = "install the package again, or name a file with --config"
    return shipped("simulated.toml", "config/simulated.toml", todo=todo)


def load(path: Path | None = None) -> Configuration:
    """Read and check a configuration file; without a path, the simulated rig's.

    Its limits of files hold from then on, in this process and in those that it starts.

    Raises
    ------
    ConfigurationError
        The file cannot be read, is not TOML, or holds a field that cannot be. The error names
        the file, the field, the value and the limit; further faulty fields are named as well.
    """
    path = default_path() if path is None else path
    found = parse(read_toml(path), str(path))
    files.set_file_limits(found.files)
    return found


def read_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file.

    Raises
    ------
    ConfigurationError
        It cannot be read, or is not TOML.
    """
    try:
        return files.read_toml(path)
    except InputError as error:
        raise ConfigurationError(
            error.reason, part=str(path), todo="name a readable file, or correct the line"
        ) from error


def parse(document: Mapping[str, Any], source: str) -> Configuration:
    """Check a document that was read elsewhere; `source` is named in errors.

    Raises
    ------
    ConfigurationError
        As `load`.
    """
    return checked(Configuration, document, source)


def checked(form: type[Model], document: Mapping[str, Any], source: str) -> Model:
    """Check a document of any form; `source` is named in errors.

    Raises
    ------
    ConfigurationError
        It holds a field that cannot be. The error names the field, the value and the limit.
    """
    found, faults = _read(form, document, source)
    if found is None:
        raise _with_others(faults)
    return found


def faults_of(
    form: type[BaseModel], document: Mapping[str, Any], source: str
) -> list[ConfigurationError]:
    """Return every fault of a document, each with field, value, limit and what to do; or none."""
    try:
        return _read(form, document, source)[1]
    except ConfigurationError as error:
        return [error]


def _read(
    form: type[Model], document: Mapping[str, Any], source: str
) -> tuple[Model | None, list[ConfigurationError]]:
    try:
        # JSON mode: an array is a tuple there, and nothing else is converted.
        return form.model_validate_json(json.dumps(document, default=_no_dates)), []
    except ValidationError as error:
        return None, _faults(form, error.errors(include_url=False), document, source)


def _no_dates(value: object) -> object:
    raise ConfigurationError(
        "a date or time has no place here", value=str(value), todo="write a number or a text"
    )


def _faults(
    form: type[BaseModel], errors: list[ErrorDetails], document: Mapping[str, Any], source: str
) -> list[ConfigurationError]:
    """Return all faults; a key that is misspelt is the cause of one that is missing: it goes first.

    What is missing in its section, under the name that it means, is no fault of its own.
    """
    slips = [error for error in errors if error["type"] in _UNKNOWN]
    meant_keys = {(*error["loc"][:-1], _meant(form, error, document)) for error in slips}
    rest = [
        error
        for error in errors
        if error["type"] not in _UNKNOWN
        and not (error["type"] == "missing" and error["loc"] in meant_keys)
    ]
    return [
        *(_unknown_key(form, error, document, source) for error in slips),
        *(_fault(error, document, source) for error in rest),
    ]


def _fault(error: ErrorDetails, document: Mapping[str, Any], source: str) -> ConfigurationError:
    field, missing = _field(error, document), error["type"] in {"missing", "union_tag_not_found"}
    value, limit = None if missing else _value(error), _limit(error)
    unit = unit_of(field.rpartition(".")[2].partition("[")[0])
    given = error["input"]
    if unit != RATIO and isinstance(given, int | float) and not isinstance(given, bool):
        value, limit = (None if text is None else f"{text} {unit}" for text in (value, limit))
    return ConfigurationError(
        _clause(error),
        part=f"{source}: {field}" if field else source,
        value=value,
        limit=limit,
        todo="add it" if missing else "correct it",
    )


def _with_others(faults: Sequence[ConfigurationError]) -> ConfigurationError:
    """Return the first of some faults; the fields of the others stand in it."""
    first, *others = faults
    if not others:
        return first
    todo = f"{first.todo}; also {', '.join(_named(one) for one in others)}"
    return ConfigurationError(
        first.what, part=first.part, value=first.value, limit=first.limit, todo=todo
    )


def _named(fault: ConfigurationError) -> str:
    """Return the field of a fault, or what it says where its part is the whole file."""
    _, is_of_a_field, field = (fault.part or "").rpartition(": ")
    return field if is_of_a_field else fault.what


def _unknown_key(
    form: type[BaseModel], error: ErrorDetails, document: Mapping[str, Any], source: str
) -> ConfigurationError:
    key = _meant(form, error, document)
    todo = "take it out, or correct it" if key is None else f"did you mean {key}?"
    field = _field(error, document)
    return ConfigurationError(f"unknown key {field}", part=source, value=_value(error), todo=todo)


def _meant(form: type[BaseModel], error: ErrorDetails, document: Mapping[str, Any]) -> str | None:
    """Return the key that an unknown one is a slip of."""
    *section, _ = error["loc"]
    return meant(form, error["loc"], _keys_at(document, section))


def _keys_at(document: object, place: Sequence[int | str]) -> tuple[str, ...]:
    """Return the keys of a section; a tag that pydantic names on the way is no step of the file."""
    for step in place:
        if isinstance(step, int):
            document = document[step] if isinstance(document, list) else None
        elif isinstance(document, Mapping):
            document = document.get(step, document)
    return tuple(document) if isinstance(document, Mapping) else ()


def _field(error: ErrorDetails, document: object) -> str:
    """Return the path as written in the file: Pydantic also names the chosen driver on the way."""
    location = error["loc"]
    if error["type"].startswith("union_tag"):
        location = (*location, error["ctx"]["discriminator"].strip("'"))
    path, here = "", document
    for position, step in enumerate(location):
        last = position == len(location) - 1 and error["type"] != "value_error"
        if isinstance(step, int):
            path += f"[{step}]"
            here = here[step] if isinstance(here, list) and step < len(here) else None
        elif isinstance(here, Mapping) and (step in here or last):
            path += f".{step}" if path else step
            here = here.get(step)
    return path


def _clause(error: ErrorDetails) -> str:
    if error["type"] in {"missing", "union_tag_not_found"}:
        return "is missing"
    if error["type"] == "union_tag_invalid":
        return "names nothing that exists"
    if error["type"] == "value_error":
        return str(error["ctx"]["error"])
    message = error["msg"]
    return message[0].lower() + message[1:]


def _limit(error: ErrorDetails) -> str | None:
    context = error.get("ctx", {})
    parts = [text.format(context[key]) for key, text in _BOUNDS.items() if key in context]
    return ", ".join(parts) or None


def _value(error: ErrorDetails) -> str | None:
    if error["type"] == "union_tag_invalid":
        return repr(error["ctx"]["tag"])
    # A whole section is no value: its own sentence says what in it disagrees.
    return None if isinstance(error["input"], dict) else repr(error["input"])


@dataclass(frozen=True, slots=True)
class _Section:
    """One form of a section: its fields by name, as annotated."""

    fields: dict[str, Any]

    def is_chosen_by(self, tag: str) -> bool:
        """Say whether one of its fields is always this text, as the driver of a device is."""
        return any(tag in _texts(kind) for kind in self.fields.values())


def meant(form: type, place: tuple[int | str, ...], present: Collection[str]) -> str | None:
    """Return the key that an unknown one is a slip of; None where none is like it.

    Parameters
    ----------
    form
        Model of the whole document.
    place
        Where the unknown key is, as pydantic names it: with the tag of a section that has several
        forms, and numbers in lists.
    present
        Keys of the same section, which are not meant.
    """
    *path, key = place
    sections = list(_sections(form))
    for step in path:
        if isinstance(step, int):
            continue
        inner = [each.fields[step] for each in sections if step in each.fields]
        chosen = [each for each in sections if each.is_chosen_by(step)]
        sections = [found for kind in inner for found in _sections(kind)] if inner else chosen
    names = {name for each in sections for name in each.fields} - set(present)
    return next(iter(get_close_matches(str(key), sorted(names), n=1)), None)


def _sections(kind: object) -> Iterator[_Section]:
    """Give every form of section within an annotation: models in unions, lists, annotations."""
    fields = getattr(kind, "__pydantic_fields__", None)
    if fields is not None:
        yield _Section({name: field.annotation for name, field in fields.items()})
        return
    for inner in () if get_origin(kind) is Literal else get_args(kind):
        yield from _sections(inner)


def _texts(kind: object) -> tuple[object, ...]:
    return get_args(kind) if get_origin(kind) is Literal else ()
