"""Frames from a multi-page TIFF: all that the file declares, or an error.

Its directories are gone through once before a library follows them. A damaged file can have a
directory that follows itself, a tag of a billion values, or values that lie beyond the file's end;
a library reads the first for ever and holds the second in memory.
"""

from __future__ import annotations

import logging
import math
import re
import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import tifffile
from numpy.typing import NDArray

from analysis.errors import InputError, counted
from analysis.files import FrameBudget

# What the library finds wrong comes back as a refusal; its own lines would stand beside it.
logging.getLogger("tifffile").addHandler(logging.NullHandler())

_ZLIB = {tifffile.COMPRESSION.ADOBE_DEFLATE, tifffile.COMPRESSION.DEFLATE}
_PADDING = 2
"""A packed strip or tile may unpack to this many times the page: some writers fill up the last."""
_OME_PIXELS = re.compile(r"<(?:\w+:)?Pixels\b[^>]*>")
_OME_SIZES = re.compile(r"\bSize[ZCT]\s*=\s*[\"'](\d{1,9})[\"']")
_VALUE_BYTES = (0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8)
"""Bytes of one value by the number of its type; 0 where there is no such type."""
_TEXTS = (1, 2, 6, 7)
"""Types of one byte, which a library holds as they are."""
_MOST_VALUES = 1_000_000
"""Numbers in the tags of one directory: a library makes an object of each."""


def read_tiff(path: Path, budget: FrameBudget) -> list[NDArray[np.generic]]:
    """Return the pages of a TIFF in their order.

    Raises
    ------
    InputError
        Damaged, beyond the budget, or shorter than its pages, the last page's pointer or its
        description (ImageJ, OME, tifffile) say; with the frame.
    """
    pages: list[NDArray[np.generic]] = []
    size = path.stat().st_size
    found = _walk(path, budget)
    try:
        # Other files that a description names are not looked for.
        with tifffile.TiffFile(path, _multifile=False) as tiff:
            each = zip(islice(tiff.pages, len(found.value_ends)), found.value_ends, strict=False)
            for index, (page, end_of_values) in enumerate(each):
                _require_whole(path, index, page, end_of_values, size)
                budget.claim(page.shape or (0,), page.dtype.itemsize if page.dtype else 1)
                _require_readable(path, index, page, tiff.filehandle)
                pages.append(page.asarray(maxworkers=1))
            if pages and not found.ends_well:
                raise InputError(
                    path,
                    f"truncated after frame {len(pages) - 1}: the next frame lies beyond the "
                    f"file's end at byte {size}",
                )
            declared = _declared(tiff)
            if len(pages) == 1 < declared and tiff.pages.first.is_contiguous:
                return _behind_one_page(path, tiff, declared, budget)
            if len(pages) < declared:
                raise InputError(
                    path,
                    f"truncated after frame {len(pages) - 1}: its description counts "
                    f"{counted(declared, 'frame')}",
                )
    except InputError:
        raise
    # A damaged TIFF makes the library raise whatever its parser stumbles over.
    except Exception as error:
        whole = counted(len(pages), "whole frame")
        raise InputError(path, f"damaged after {whole}: {error}") from error
    return pages


def holds_pages(path: Path) -> bool:
    """Return whether a file is a TIFF of several pages: a film, and no picture of one."""
    try:
        with tifffile.TiffFile(path, _multifile=False) as tiff:
            return len(list(islice(tiff.pages, 2))) > 1
    # A damaged file makes the library raise whatever its parser stumbles over.
    except Exception:  # noqa: BLE001
        return False


def _require_whole(path: Path, index: int, page: Any, end_of_values: int, size: int) -> None:  # noqa: ANN401
    """Refuse a page whose data or values lie beyond the end; the library passes over the latter."""
    places = zip(page.dataoffsets, page.databytecounts, strict=True)
    end = max((offset + length for offset, length in places), default=0)
    if end > size:
        raise _truncated(path, index, end, size)
    if end_of_values > size:
        raise _truncated(path, index, end_of_values, size, "its tags")


def _truncated(path: Path, frame: int, end: int, size: int, part: str = "its data") -> InputError:
    return InputError(
        path, f"truncated in frame {frame}: {part} end at byte {end}, the file at {size}"
    )


def _require_readable(path: Path, index: int, page: Any, file: Any) -> None:  # noqa: ANN401
    """Refuse a compression that is not read, and data that unpack to more than their page."""
    tile = page.tilewidth * page.tilelength * max(1, page.tiledepth) if page.is_tiled else 0
    if tile > _PADDING * max(page.size, 2**20):
        raise InputError(path, f"damaged in frame {index}: a tile of {tile} pixels for {page.size}")
    if page.compression == tifffile.COMPRESSION.NONE:
        return
    if page.compression not in _ZLIB:
        name = tifffile.COMPRESSION(page.compression).name
        raise InputError(path, f"compressed as {name}; save it uncompressed or compressed as zlib")
    most = _PADDING * max(page.nbytes, tile * page.dtype.itemsize)
    for offset, length in zip(page.dataoffsets, page.databytecounts, strict=True):
        file.seek(offset)
        if len(zlib.decompressobj().decompress(file.read(length), most + 1)) > most:
            raise InputError(
                path,
                f"damaged in frame {index}: its data unpack to more than {most} bytes, the frame "
                f"has {page.nbytes}",
            )


def _declared(tiff: tifffile.TiffFile) -> int:
    """Return how many frames the description in the file counts; 0 where it has none."""
    size = tiff.pages.first.size
    if size == 0:
        return 0
    if tiff.is_imagej:
        return int((tiff.imagej_metadata or {}).get("images", 0))
    if tiff.is_ome:
        images = _OME_PIXELS.findall(tiff.ome_metadata or "")
        planes = (math.prod(map(int, _OME_SIZES.findall(image))) for image in images)
        return sum(planes) // max(1, int(tiff.pages.first.samplesperpixel))
    shapes = [tuple(each.get("shape", (0,))) for each in tiff.shaped_metadata or ()]
    return int(sum(math.prod(shape) for shape in shapes) // size)


def _behind_one_page(
    path: Path, tiff: tifffile.TiffFile, frames: int, budget: FrameBudget
) -> list[NDArray[np.generic]]:
    """Return frames that lie one after another behind a single page, as large stacks do."""
    page = tiff.pages.first
    start, length, size = page.dataoffsets[0], page.nbytes, path.stat().st_size
    if start + frames * length > size:
        first_cut = (size - start) // length
        raise _truncated(path, first_cut, start + (first_cut + 1) * length, size)
    budget.require_frames(frames)
    kind = np.dtype(page.dtype).newbyteorder(tiff.byteorder)
    for _ in range(frames - 1):
        budget.claim(page.shape, kind.itemsize)
    values = np.fromfile(path, dtype=kind, count=frames * page.size, offset=start)
    return list(values.reshape(frames, *page.shape))


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
class _Walk:
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


def _walk(path: Path, budget: FrameBudget) -> _Walk:
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
                return _Walk((*ends, *(() if found is None else (found[0],))), ends_well=False)
            end, offset = found[0], found[1]
            ends.append(end)
            budget.require_frames(len(ends))
            budget.require_time()
            if end > size:
                break
    return _Walk(tuple(ends), ends_well=not offset)


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
    if values > _MOST_VALUES:
        raise InputError(
            path,
            f"frame {frame} has {values} numbers in its tags, allowed are {_MOST_VALUES}; save it "
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
