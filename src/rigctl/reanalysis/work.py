"""What is done wherever shots are analysed, and what is sent back of it."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Self

from analysis.setup import without_exposure
from rigctl.documents import Json
from rigctl.errors import RigError
from rigctl.store.folders import result_text

if TYPE_CHECKING:
    from analysis.photometric.learn.appearance import Appearance


# The parameters' numbers in malloc.h.
_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3
LARGEST_KEPT = 32 << 20
"""Bytes of the largest array whose memory is kept: the limit to which the GNU C library adapts by
itself where none is set."""


@cache
def keep_memory() -> None:
    """Keep the memory of arrays for the next ones, up to 64 MiB of it in this process.

    It is a matter of time alone. Where the C library is not GNU's, nothing is done.
    """
    library = ctypes.CDLL(None)
    # As elsewhere in that library: what is free at the end of the heap may be twice as much.
    for parameter, size in ((_MMAP_THRESHOLD, LARGEST_KEPT), (_TRIM_THRESHOLD, 2 * LARGEST_KEPT)):
        if hasattr(library, "mallopt"):
            library.mallopt(parameter, size)


LONG = frozenset({"poses", "overlay"})
"""Bulky fields of a result that the storing process does not need."""


@dataclass(frozen=True, slots=True)
class Found:
    """What an analysis found.

    Attributes
    ----------
    text
        The result as its file is to have it: to make it takes longer than to store it, and those
        who analyse are many.
    brief
        The result without what is `LONG`.
    """

    text: bytes
    brief: Json

    @classmethod
    def of(cls, result: Json) -> Self:
        """Return a result in this form; raise `ValueError` for a number that is not finite."""
        brief = {name: value for name, value in result.items() if name not in LONG}
        return cls(result_text(result), brief)


@dataclass(frozen=True, slots=True)
class Broken:
    """Why the analysis of a shot came to nothing, in words that any process understands."""

    why: str

    @classmethod
    def of(cls, error: Exception) -> Self:
        """Return the words of an error."""
        if isinstance(error, RigError):
            return cls(error.sentence())
        return cls(f"{type(error).__name__}: {error}")


def analysed(
    folders: Sequence[Path], method: str, known: Appearance | None
) -> list[Found | Broken]:
    """Analyse shots one after another; one that breaks stops no other."""
    # Loaded only by the process that analyses.
    from rigctl.measuring.stored_shot import analyse_stored_shot_with  # noqa: PLC0415

    keep_memory()
    found: list[Found | Broken] = []
    for folder in folders:
        try:
            found.append(Found.of(analyse_stored_shot_with(folder, method, known)))
        except Exception as error:  # noqa: BLE001 - whatever breaks is this shot's failure alone
            found.append(Broken.of(error))
    return found


def taught(folders: Sequence[Path]) -> Appearance | None:
    """Return what shots teach of their spheres; those that cannot do not."""
    from analysis.photometric.teaching import teach  # noqa: PLC0415
    from rigctl.measuring.stored_shot import read_stored_shot  # noqa: PLC0415

    keep_memory()
    read = [read_stored_shot(folder) for folder in folders]
    setup = without_exposure(read[0][2])
    return teach([shot for shot in read if without_exposure(shot[2]) == setup])
