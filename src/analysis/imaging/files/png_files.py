"""Frames from a folder of PNG files, in the order of the numbers in their names."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.errors import InputError
from analysis.files import FrameBudget
from analysis.imaging.files.png_check import head_of, plain

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
