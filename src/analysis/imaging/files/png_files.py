"""Frames from a folder of PNG files, in the order of the numbers in their names.

A library gives the rows of a damaged file as far as they go, and writes what it stumbles over to
standard error: each file is held whole, from its first chunk to its last row, before it is read.
Sections are those of the PNG specification, third edition.
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.errors import InputError
from analysis.files import FrameBudget

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_HEAD = struct.Struct(">IIBBBBB")
_VALUES = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
"""Values of a pixel by the colour type (11.2.1)."""
_DEPTHS = {0: {1, 2, 4, 8, 16}, 2: {8, 16}, 3: {1, 2, 4, 8}, 4: {8, 16}, 6: {8, 16}}
_KNOWN = {b"IHDR", b"PLTE", b"IDAT", b"IEND"}
MOST_FILTER = 4
_PASSES = (
    (0, 0, 8, 8),
    (0, 4, 8, 8),
    (4, 0, 8, 4),
    (0, 2, 4, 4),
    (2, 0, 4, 2),
    (0, 1, 2, 2),
    (1, 0, 2, 1),
)
"""First row and column, and the steps between rows and columns, of interlaced passes (8.2)."""


@dataclass(frozen=True, slots=True)
class Head:
    """What the first chunk says of a picture."""

    height: int
    width: int
    depth: int
    colour: int
    interlaced: bool

    @property
    def value_bytes(self) -> int:
        """Bytes of a pixel once a palette is resolved."""
        values = 3 if self.colour == 3 else _VALUES[self.colour]
        return values * (2 if self.depth == 16 else 1)

    def rows(self) -> Iterator[tuple[int, int]]:
        """Give of each pass how many rows it has, and the bytes of a row with its filter."""
        bits = self.depth * _VALUES[self.colour]
        passes = _PASSES if self.interlaced else ((0, 0, 1, 1),)
        for row, column, down, across in passes:
            rows = max(0, -(-(self.height - row) // down))
            columns = max(0, -(-(self.width - column) // across))
            if rows and columns:
                yield rows, 1 + -(-columns * bits // 8)


def head_of(content: bytes) -> Head:
    """Return what the first chunk says; raise `ValueError` where it is none."""
    for name, body in _chunks(content):
        if name != b"IHDR" or len(body) != _HEAD.size:
            break
        width, height, depth, colour, packing, filtering, interlace = _HEAD.unpack(body)
        if depth not in _DEPTHS.get(colour, ()) or packing or filtering or interlace > 1:
            raise ValueError("its first chunk has no known form")
        if not (width and height):
            raise ValueError(f"it has {height} x {width} pixels")
        return Head(height, width, depth, colour, interlaced=interlace == 1)
    raise ValueError("it does not begin with IHDR")


def plain(content: bytes, head: Head) -> bytes:
    """Return a PNG of the same picture with nothing beside what shows it.

    Texts, profiles and animations are left out: no reader need unpack them.

    Raises
    ------
    ValueError
        A chunk is cut, damaged, unknown or out of place, or the rows are not all there.
    """
    kept = [(name, body) for name, body in _chunks(content) if name in _KNOWN]
    names = [name for name, _ in kept]
    palettes = names.count(b"PLTE")
    first = 2 if palettes else 1
    expected = [b"IHDR", *[b"PLTE"] * palettes, *[b"IDAT"] * (len(names) - first - 1), b"IEND"]
    if names != expected or b"IDAT" not in names or palettes > 1 or kept[-1][1]:
        raise ValueError("its chunks are not all there, or out of order")
    if (head.colour == 3) != (palettes == 1) and head.colour in {0, 3, 4}:
        raise ValueError("its palette is missing or out of place")
    if palettes and (len(kept[1][1]) % 3 or not 3 <= len(kept[1][1]) <= 768):
        raise ValueError("its palette is none")
    _require_rows(b"".join(body for name, body in kept if name == b"IDAT"), head)
    return _SIGNATURE + b"".join(map(_packed, kept))


def _chunks(content: bytes) -> Iterator[tuple[bytes, bytes]]:
    if not content.startswith(_SIGNATURE):
        raise ValueError("it does not begin as one")
    place = len(_SIGNATURE)
    while place < len(content):
        if place + 12 > len(content):
            raise ValueError("it is cut within a chunk")
        length, name = struct.unpack_from(">I4s", content, place)
        end = place + 12 + length
        if end > len(content):
            raise ValueError(f"it is cut within chunk {name!r}")
        body = content[place + 8 : end - 4]
        if zlib.crc32(content[place + 4 : end - 4]) != int.from_bytes(content[end - 4 : end]):
            raise ValueError(f"the check sum of chunk {name!r} is wrong")
        if name[:1].isupper() and name not in _KNOWN:
            raise ValueError(f"chunk {name!r} is not known")
        yield name, body
        if name == b"IEND":
            return
        place = end


def _require_rows(packed: bytes, head: Head) -> None:
    passes = list(head.rows())
    size = sum(rows * length for rows, length in passes)
    unpacker = zlib.decompressobj()
    try:
        rows = unpacker.decompress(packed, size)
        # The check sum lies behind the last row.
        rest = b"" if unpacker.eof else unpacker.decompress(unpacker.unconsumed_tail, 1)
    except zlib.error as error:
        raise ValueError(f"its rows cannot be unpacked: {error}") from error
    if len(rows) != size or rest or not unpacker.eof:
        raise ValueError(f"its rows unpack to another size than {size} bytes")
    start = 0
    for count, length in passes:
        if max(rows[start : start + count * length : length]) > MOST_FILTER:
            raise ValueError("a row has an unknown filter")
        start += count * length


def _packed(chunk: tuple[bytes, bytes]) -> bytes:
    name, body = chunk
    return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))


SUFFIX = ".png"
_NUMBER = re.compile("[0-9]+")


def holds_png(folder: Path) -> bool:
    """Return whether a folder could be a shot's frames."""
    return any(path.suffix.lower() == SUFFIX for path in folder.iterdir())


def read_pngs(folder: Path, budget: FrameBudget) -> list[NDArray[np.generic]]:
    """Return the frames of a folder.

    Raises
    ------
    InputError
        No PNG is there, their names give no order, one is damaged, or they are beyond the budget.
    """
    names = numbered_files(folder, SUFFIX)
    if not names:
        raise InputError(folder, "a folder without PNG files")
    budget.require_frames(len(names))
    return [read_picture(name, budget) for name in names]


def read_picture(path: Path, budget: FrameBudget) -> NDArray[np.generic]:
    """Return what a PNG file shows; raise `InputError` where it is damaged or too large."""
    content = path.read_bytes() if path.stat().st_size <= budget.most_bytes else b""
    try:
        head = head_of(content)
        budget.claim((head.height, head.width), head.value_bytes)
        page = cv2.imdecode(np.frombuffer(plain(content, head), np.uint8), cv2.IMREAD_UNCHANGED)
    except (ValueError, cv2.error) as error:
        raise InputError(path, f"not a whole PNG file: {error}") from error
    if page is None:
        raise InputError(path, "not a whole PNG file")
    return np.asarray(page)


def refuse_single(path: Path) -> None:
    """Refuse one picture in the place of a film; raise `InputError`, which says if it is damaged.

    A film of pictures is a folder.
    """
    read_picture(path, FrameBudget(path))
    raise InputError(path, "is one picture and no film: give the folder that holds the pictures")


def numbered_files(folder: Path, suffix: str) -> list[Path]:
    """Return the files of a folder with a suffix in the order of the numbers in their names.

    Raises
    ------
    InputError
        Two names differ in more than their numbers, or have the same numbers.
    """
    names = [path for path in folder.iterdir() if path.suffix.lower() == suffix]
    names.sort(key=lambda path: (_numbers(path), path.name))
    for first, second in pairwise(names):
        if _NUMBER.sub("#", first.stem) != _NUMBER.sub("#", second.stem):
            why = "differ in more than their numbers"
        elif _numbers(first) == _numbers(second):
            why = "have the same numbers"
        else:
            continue
        raise InputError(
            folder,
            f"{first.name} and {second.name} {why}, which gives no order; name the frames "
            f"0000{suffix}, 0001{suffix} and so on",
        )
    return names


def _numbers(path: Path) -> list[int]:
    return [int(digits) for digits in _NUMBER.findall(path.stem)]
