"""Frames from an NPY file, whose header is checked against the file before anything is held.

The format's own description (numpy.lib.format) has the header as a literal of Python; here it is
taken in the form in which it is written, and nothing of it is run.
"""

from __future__ import annotations

import math
import re
import struct
from pathlib import Path
from typing import BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray

from analysis.errors import InputError
from analysis.files import FrameBudget

_MAGIC = b"\x93NUMPY"
_LENGTHS = {(1, 0): "<H", (2, 0): "<I", (3, 0): "<I"}
"""How the length of the header is written, by the version of the format."""
MOST_HEADER_BYTES = 10_000
_HEADER = re.compile(
    rb"\s*\{\s*'descr':\s*(?P<kind>'[^']{1,99}'|\[.*\]),\s*'fortran_order':\s*(?P<order>True|False),"
    rb"\s*'shape':\s*\((?P<shape>[0-9, ]*)\),?\s*\}\s*",
    re.DOTALL,
)
_KIND = re.compile(r"[<>|=]?[?bBhHiIlLqQefdgFDGOiufcSUVMm][0-9]{0,6}")


class _Header(NamedTuple):
    kind: np.dtype[np.generic]
    fortran: bool
    shape: tuple[int, ...]


def read_npy(path: Path, budget: FrameBudget) -> NDArray[np.generic]:
    """Return the array of an NPY file, the first axis counting frames.

    Raises
    ------
    InputError
        Its header is broken, speaks of Python objects, or of more than the file holds or the
        budget allows.
    """
    with path.open("rb") as file:
        try:
            kind, fortran, shape = _header(file)
        except ValueError as error:
            raise _broken(path, str(error)) from error
        size, there = math.prod(shape) * kind.itemsize, path.stat().st_size - file.tell()
        if size > there:
            raise _broken(path, f"its header speaks of {size} bytes, {there} follow it")
        frames = shape[0] if shape else 1
        budget.require_frames(frames)
        for _ in range(frames):
            budget.claim(shape[1:], kind.itemsize)
        values = np.fromfile(file, dtype=kind, count=math.prod(shape))
    return values.reshape(shape, order="F" if fortran else "C")


def _header(file: BinaryIO) -> _Header:
    head = file.read(8)
    form = _LENGTHS.get((head[6], head[7])) if len(head) == 8 else None
    if form is None or head[:6] != _MAGIC:
        raise ValueError("it does not begin as one of version 1.0 to 3.0")
    field = file.read(struct.calcsize(form))
    if len(field) < struct.calcsize(form):
        raise ValueError("it ends within its header")
    (length,) = struct.unpack(form, field)
    text = file.read(min(length, MOST_HEADER_BYTES + 1))
    found = _HEADER.fullmatch(text)
    if len(text) != length or found is None:
        raise ValueError(f"its header of {length} bytes names no kind, order and shape of values")
    shape = tuple(int(part) for part in found["shape"].split(b",") if part.strip())
    return _Header(_kind(found["kind"].decode("latin-1")), found["order"] == b"True", shape)


def _kind(described: str) -> np.dtype[np.generic]:
    if described.startswith("["):
        raise ValueError("it holds records")
    name = described.strip("'")
    if not _KIND.fullmatch(name):
        raise ValueError(f"{described} is no kind of values")
    try:
        kind = np.dtype(name)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{described} is no kind of values") from error
    if kind.hasobject:
        raise ValueError("it holds Python objects")
    if kind.itemsize == 0:
        raise ValueError(f"values of kind {described} have no bytes")
    return kind


def _broken(path: Path, why: str) -> InputError:
    return InputError(path, f"not a whole NPY file: {why}")
