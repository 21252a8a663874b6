"""Output that waits in a temporary file until it can be printed: a long one needs no memory."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from contextlib import suppress
from tempfile import TemporaryFile
from typing import Any, Self

from rigctl.temporary_room import temporary_room

Json = Mapping[str, Any]
PRINTED = "what is to be printed"


class Spool:
    """Lines of text, written once and read as often as wanted.

    Every method raises `StoreError` where the temporary folder is full.
    """

    def __init__(self) -> None:
        with temporary_room(PRINTED):
            self._file = TemporaryFile("w+", encoding="utf-8", newline="\n")  # noqa: SIM115

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        # What never found room is lost with an error of its own already.
        with suppress(OSError):
            self._file.close()

    def add(self, line: str) -> None:
        """Append a line, which holds no line break."""
        with temporary_room(PRINTED):
            self._file.write(f"{line}\n")

    def lines(self) -> Iterator[str]:
        """Give what was added, without line breaks."""
        with temporary_room(PRINTED):
            self._file.seek(0)
            for line in self._file:
                yield line.removesuffix("\n")


def print_document(head: Json, listed: str, items: Spool, tail: Json | None = None) -> None:
    """Print one JSON document: fields, a list of the JSON objects in a spool, and more fields.

    Parameters
    ----------
    head, tail
        Fields before and after the list.
    listed
        Name of the list.
    items
        One object a line.

    Raises
    ------
    StoreError
        As `Spool`.
    """
    write = sys.stdout.write
    write(f"{_fields(head)[:-1]}, {json.dumps(listed)}: [")
    for place, item in enumerate(items.lines()):
        write(f",\n{item}" if place else f"\n{item}")
    write(f"], {_fields(tail)[1:]}\n" if tail else "]}\n")


def _fields(part: Json) -> str:
    return json.dumps(part, allow_nan=False)
