"""JSON and TOML of bounded size and depth, whose whole numbers fit into 64 bits."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Literal, TypeVar

from analysis.errors import InputError
from analysis.files.limits import file_limits

Table = dict[str, Any]
Found = TypeVar("Found")

MOST_DOTS = 200
"""In one line of TOML, those between digits aside: the parser's time grows with their square."""
_LOOSE_DOT = re.compile(r"(?<![0-9])\.|\.(?![0-9])")
_SEPARATOR = re.compile("[,=]")
_LARGEST = 2**63


def read_toml(path: Path) -> Table:
    """Read a TOML file, with or without a byte order mark.

    Raises
    ------
    InputError
        Absent, unreadable, too large, too deep, or not TOML.
    """
    return parse_toml(path, read_bytes(path, "settings_kb"))


def parse_toml(path: Path, content: bytes) -> Table:
    """Return parsed TOML; `path` is named in refusals, as in `read_toml`."""
    return _parsed(path, "TOML", lambda: _toml(content))


def read_json(path: Path) -> object:
    """Read a JSON file.

    Raises
    ------
    InputError
        Absent, unreadable, too large, too deep, or not JSON in UTF-8.
    """
    return parse_json(path, read_bytes(path, "document_mb"))


def parse_json(path: Path, content: bytes) -> object:
    """Return parsed JSON; `path` is named in refusals, as in `read_json`."""
    return _parsed(path, "JSON", lambda: json.loads(content.decode("utf-8")))


def read_bytes(path: Path, limit: Literal["document_mb", "settings_kb"]) -> bytes:
    """Return the content of a file that is no larger than a limit of `FileLimits`.

    Raises
    ------
    InputError
        Absent, unreadable, or larger.
    """
    most = {"document_mb": 1e6, "settings_kb": 1e3}[limit] * getattr(file_limits(), limit)
    try:
        with path.open("rb") as file:
            content = file.read(int(most) + 1)
    except FileNotFoundError as error:
        raise InputError(path, "no such file") from error
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from error
    if len(content) > most:
        raise InputError(
            path,
            f"has more than {most:.0f} bytes; shorten it, or raise files.{limit} in the "
            "configuration",
        )
    return content


def _parsed(path: Path, form: str, parse: Callable[[], Found]) -> Found:
    try:
        found = parse()
    except RecursionError as error:
        raise InputError(path, f"not {form}: nested beyond {file_limits().depth} levels") from error
    except ValueError as error:
        raise InputError(path, f"not {form}: {error}") from error
    _require_plain(path, form, found)
    return found


def _toml(content: bytes) -> Table:
    # Line ends of any system, as in Python's own text files.
    text = content.decode("utf-8-sig").replace("\r\n", "\n")
    for number, line in enumerate(text.split("\n"), start=1):
        dots = max(part.count(".") for part in _SEPARATOR.split(line))
        if max(dots, len(_LOOSE_DOT.findall(line))) > MOST_DOTS:
            raise ValueError(f"line {number} has more than {MOST_DOTS} dots")
    return tomllib.loads(text)


def _require_plain(path: Path, form: str, document: object) -> None:
    depth = file_limits().depth
    level = [document]
    for _ in range(depth + 1):
        level = [inner for value in level for inner in _within(value)]
        for value in level:
            if type(value) is int and not -_LARGEST <= value < _LARGEST:
                raise InputError(path, f"not {form}: a whole number does not fit into 64 bits")
        if not level:
            return
    raise InputError(path, f"not {form}: nested beyond {depth} levels")


def _within(value: object) -> list[Any]:
    if isinstance(value, dict):
        return list(value.values())
    return value if isinstance(value, list) else []


def toml_text(document: Mapping[str, Any]) -> str:
    """Return TOML that reads back as a document of values, tables, and lists of tables.

    Text, numbers and lists are written as JSON has them: for these TOML reads the same. What is
    None is left out.
    """
    own = {name: value for name, value in document.items() if not _is_table(value)}
    parts = ["\n".join(_lines(own))] if own else []
    for name, value in document.items():
        if _is_table(value):
            tables, heading = (
                ([value], f"[{name}]") if isinstance(value, Mapping) else (value, f"[[{name}]]")
            )
            parts += ["\n".join([heading, *_lines(table)]) for table in tables]
    return "\n\n".join(parts) + "\n"


def _is_table(value: object) -> bool:
    return isinstance(value, Mapping) or (
        isinstance(value, list) and bool(value) and all(isinstance(one, Mapping) for one in value)
    )


def _lines(table: Mapping[str, Any]) -> list[str]:
    return [f"{name} = {_value(value)}" for name, value in table.items() if value is not None]


def _value(value: object) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(_lines(value)) + " }"
    # TOML takes neither surrogate pairs nor, as JSON does, a bare delete.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
