"""A list that lies in a file."""

from __future__ import annotations

import pickle
from array import array
from collections.abc import Iterator
from tempfile import TemporaryFile
from typing import Generic, TypeVar
from weakref import finalize

T = TypeVar("T")


class Spool(Generic[T]):
    """Things of one kind, added one after another and read in the same order, as often as wanted.

    They lie in a temporary file without a name, in the folder that `TMPDIR` names, and go with the
    object. `OSError`: the file cannot be written; its folder may be full.

    Parameters
    ----------
    kind
        What is kept, as `analysis.model.data.parts.Keeper` has it.
    """

    def __init__(self, kind: type[T]) -> None:
        self._kind = kind
        self._file = TemporaryFile()  # noqa: SIM115
        self._starts, self._end = array("q"), 0
        finalize(self, self._file.close)

    def __len__(self) -> int:
        return len(self._starts)

    def append(self, item: T, /) -> None:
        """Write what is to be kept after the last that was written whole."""
        self._file.seek(self._end)
        pickle.dump(item, self._file, pickle.HIGHEST_PROTOCOL)
        self._starts.append(self._end)
        self._end = self._file.tell()

    def __iter__(self) -> Iterator[T]:
        """Read what was kept, from the first on; several may read at once."""
        for place in range(len(self)):
            yield self.item(place)

    def item(self, place: int) -> T:
        """Return what was added as number `place`, from 0."""
        self._file.seek(self._starts[place])
        # Nobody else can have written this file: it never had a name.
        item = pickle.load(self._file)  # noqa: S301
        if not isinstance(item, self._kind):
            raise TypeError(f"{type(item).__name__} in a spool of {self._kind.__name__}")
        return item
