"""Frames from a multi-page TIFF, every one that the file speaks of or none."""

from __future__ import annotations

import logging
import math
import struct
from pathlib import Path

import numpy as np
import tifffile
from numpy.typing import NDArray

from analysis.errors import InputError, counted

# What the library finds wrong comes back as a refusal; its own lines would stand beside it.
logging.getLogger("tifffile").addHandler(logging.NullHandler())

_VALUE_BYTES = (0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8)
"""Bytes of one value by the number of its type; 0 where there is no such type."""


def read_tiff(path: Path) -> list[NDArray[np.generic]]:
    """Return the pages of a TIFF in their order.

    Raises
    ------
    InputError
        Damaged, or shorter than its pages, the last page's pointer or its description (ImageJ,
        OME, tifffile) say; with the frame.
    """
    pages: list[NDArray[np.generic]] = []
    try:
        with tifffile.TiffFile(path) as tiff:
            size = path.stat().st_size
            for index, page in enumerate(tiff.pages):
                end = max(
                    (o + n for o, n in zip(page.dataoffsets, page.databytecounts, strict=True)),
                    default=0,
                )
                if end > size:
                    raise _truncated(path, index, end, size)
                if (end := _end_of_values(tiff, page.offset)) > size:
                    raise _truncated(path, index, end, size, "its tags")
                if page.compression not in tifffile.TIFF.DECOMPRESSORS:
                    name = tifffile.COMPRESSION(page.compression).name
                    raise InputError(
                        path, f"compressed as {name}; save it uncompressed or compressed as zlib"
                    )
                pages.append(page.asarray())
            if pages and not _ends_with_last_page(tiff):
                raise InputError(
                    path,
                    f"truncated after frame {len(pages) - 1}: the next frame lies beyond the "
                    f"file's end at byte {size}",
                )
            declared = _declared(tiff)
            if len(pages) == 1 < declared and tiff.pages.first.is_contiguous:
                return _behind_one_page(path, tiff, declared)
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


def _truncated(path: Path, frame: int, end: int, size: int, part: str = "its data") -> InputError:
    return InputError(
        path, f"truncated in frame {frame}: {part} end at byte {end}, the file at {size}"
    )


def _end_of_values(tiff: tifffile.TiffFile, offset: int) -> int:
    """Return the byte where the values of a page's tags end (TIFF 6.0, section 2).

    The library passes over a tag whose value lies beyond the end of the file.
    """
    form = tiff.tiff
    tiff.filehandle.seek(offset)
    (tags,) = struct.unpack(form.tagnoformat, tiff.filehandle.read(form.tagnosize))
    end = 0
    for _ in range(tags):
        _, kind, count, place = struct.unpack(
            form.byteorder + ("HHII" if form.offsetsize == 4 else "HHQQ"),
            tiff.filehandle.read(form.tagsize),
        )
        length = count * (_VALUE_BYTES[kind] if kind < len(_VALUE_BYTES) else 0)
        if length > form.offsetsize:
            end = max(end, place + length)
    return end


def _ends_with_last_page(tiff: tifffile.TiffFile) -> bool:
    """Return whether the last page found says that no other follows.

    The library passes over a following page that lies beyond the end of the file.
    """
    tiff.filehandle.seek(tiff.pages.next_page_offset or 0)
    following = tiff.filehandle.read(tiff.tiff.offsetsize)
    return len(following) == tiff.tiff.offsetsize and not any(following)


def _declared(tiff: tifffile.TiffFile) -> int:
    """Return how many frames the description in the file counts; 0 where it has none."""
    size = tiff.pages.first.size
    if size == 0:
        return 0
    if tiff.is_imagej:
        return int((tiff.imagej_metadata or {}).get("images", 0))
    if tiff.is_ome:
        shapes = [series.shape for series in tiff.series]
    else:
        shapes = [tuple(each.get("shape", (0,))) for each in tiff.shaped_metadata or ()]
    return sum(math.prod(shape) for shape in shapes) // size


def _behind_one_page(path: Path, tiff: tifffile.TiffFile, frames: int) -> list[NDArray[np.generic]]:
    """Return frames that lie one after another behind a single page, as large stacks do."""
    page = tiff.pages.first
    start, length, size = page.dataoffsets[0], page.nbytes, path.stat().st_size
    if start + frames * length > size:
        first_cut = (size - start) // length
        raise _truncated(path, first_cut, start + (first_cut + 1) * length, size)
    kind = np.dtype(page.dtype).newbyteorder(tiff.byteorder)
    values = np.fromfile(path, dtype=kind, count=frames * page.size, offset=start)
    return list(values.reshape(frames, *page.shape))
