"""The directories of a TIFF, gone through once before a library follows them.

A damaged file can have a directory that follows itself, a tag of a billion values, or values that
lie beyond the file's end; a library reads the first for ever and holds the second in memory.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from analysis.errors import InputError
from analysis.files import FrameBudget

_VALUE_BYTES = (0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8)
"""Bytes of one value by the number of its type; 0 where there is no such type."""
_TEXTS = (1, 2, 6, 7)
"""Types of one byte, which a library holds as they are."""
MOST_VALUES = 1_000_000
"""Numbers in the tags of one directory: a library makes an object of each."""


@dataclass(frozen=True, slots=True)
class _Form:
    """How numbers are written: classic or BigTIFF (TIFF 6.0, section 2)."""

    order: str
    large: bool

    @property
    def count(self) -> struct.Struct:
        return struct.Struct(self.order + ("Q" if self.large else "H"))

    @property
    def tag(self) -> struct.Struct:
        return struct.Struct(self.order + ("HHQQ" if self.large else "HHII"))

    @property
    def offset(self) -> struct.Struct:
        return struct.Struct(self.order + ("Q" if self.large else "I"))


@dataclass(frozen=True, slots=True)
class Walk:
    """What was found of the directories, in their order.

    Attributes
    ----------
    value_ends
        Byte where the values of a directory's tags end.
    ends_well
        Whether the last directory found says that no other follows.
    """

    value_ends: tuple[int, ...]
    ends_well: bool


def walk(path: Path, budget: FrameBudget) -> Walk:
    """Follow the directories of a TIFF.

    Raises
    ------
    InputError
        It is no TIFF; a directory follows one that it lies before; more of them than the budget
        allows; or one with too many values.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        form, offset = _head(path, file)
        ends: list[int] = []
        seen: set[int] = set()
        while offset:
            if offset in seen:
                raise InputError(
                    path, f"damaged: its directories go round, frame {len(ends)} is an earlier one"
                )
            seen.add(offset)
            found = _directory(path, file, form, offset, len(ends)) if offset < size else None
            if found is None or found[1] is None:
                # The directory, or what follows it, lies beyond the end.
                return Walk((*ends, *(() if found is None else (found[0],))), ends_well=False)
            end, offset = found[0], found[1]
            ends.append(end)
            budget.require_frames(len(ends))
            budget.require_time()
            if end > size:
                break
    return Walk(tuple(ends), ends_well=not offset)


def _head(path: Path, file: BinaryIO) -> tuple[_Form, int]:
    head = file.read(16)
    order = {b"II": "<", b"MM": ">"}.get(head[:2])
    if order is None or len(head) < 8:
        raise InputError(path, "damaged after 0 whole frames: not a TIFF")
    (version,) = struct.unpack(order + "H", head[2:4])
    form = _Form(order, large=version == 43)
    place = head[8:16] if form.large else head[4:8]
    if version not in {42, 43} or len(place) < form.offset.size:
        raise InputError(path, "damaged after 0 whole frames: not a TIFF")
    return form, int(form.offset.unpack(place)[0])


def _directory(
    path: Path, file: BinaryIO, form: _Form, offset: int, frame: int
) -> tuple[int, int | None] | None:
    """Return where the values of a directory end, and where the next one lies; None: it is cut."""
    take = _reader(file, offset)
    count = take(form.count)
    if count is None:
        return None
    if count[0] > 0xFFFF:
        raise InputError(path, f"damaged in frame {frame}: its directory has {count[0]} tags")
    end = values = 0
    for _ in range(count[0]):
        tag = take(form.tag)
        if tag is None:
            return None
        _, kind, number, place = tag
        each = _VALUE_BYTES[kind] if kind < len(_VALUE_BYTES) else 0
        values += 0 if kind in _TEXTS else number
        if number * each > form.offset.size:
            end = max(end, place + number * each)
    if values > MOST_VALUES:
        raise InputError(
            path,
            f"frame {frame} has {values} numbers in its tags, allowed are {MOST_VALUES}; save it "
            "in fewer strips",
        )
    following = take(form.offset)
    return end, None if following is None else int(following[0])


def _reader(file: BinaryIO, offset: int) -> Callable[[struct.Struct], tuple[int, ...] | None]:
    file.seek(offset)

    def take(form: struct.Struct) -> tuple[int, ...] | None:
        content = file.read(form.size)
        return form.unpack(content) if len(content) == form.size else None

    return take
