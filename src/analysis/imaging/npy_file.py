"""Frames from an NPY file, whose header is checked against the file before anything is held."""

from __future__ import annotations

import math
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from analysis.errors import InputError
from analysis.files import FrameBudget

_HEADERS = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}


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
            shape, fortran, kind = _header(file)
        # The library reads the header as Python and raises whatever that stumbles over.
        except Exception as error:
            raise _broken(path, str(error)) from error
        if kind.hasobject:
            raise _broken(path, "it holds Python objects")
        size, start = math.prod(shape) * kind.itemsize, file.tell()
        there = path.stat().st_size - start
        if min(shape, default=0) < 0 or size > there:
            raise _broken(path, f"its header speaks of {size} bytes, {there} follow it")
        budget.require_frames(shape[0] if shape else 1)
        for _ in range(shape[0] if shape else 1):
            budget.claim(shape[1:], kind.itemsize)
        try:
            values = np.fromfile(file, dtype=kind, count=math.prod(shape))
        except ValueError as error:
            raise _broken(path, str(error)) from error
    return values.reshape(shape, order="F" if fortran else "C")


def _header(file: BinaryIO) -> tuple[tuple[int, ...], bool, np.dtype[np.generic]]:
    version = npy.read_magic(file)
    if version not in _HEADERS:
        raise ValueError(f"version {version} of the format; 1.0 and 2.0 are read")
    return _HEADERS[version](file)


def _broken(path: Path, why: str) -> InputError:
    return InputError(path, f"not a whole NPY file: {why}")
