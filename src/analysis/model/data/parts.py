"""Campaigns taken so many shots at a time, in memory or from a file, and what is kept of each part.

A fit and a ranking go over the parts again and again and add up; only sums grow no further with
the number of shots. Sums are rounded part by part, so that the same parts give the same digits
wherever they are kept.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Protocol, Self, TypeVar

SHOTS_AT_ONCE = 128
"""So many that what is done once for each part is little. Working arrays go with it: beyond 128 a
campaign of 1000 shots takes a fifth more memory than one of 100 (python -m benchmarks.discovery
memory)."""

T = TypeVar("T")


class Kept(Protocol[T]):
    """What is kept of each part: added in order, read in the same order, as often as wanted."""

    def append(self, item: T, /) -> None:
        """Add what is kept of the next part."""

    def __iter__(self) -> Iterator[T]:
        """Return what was added, from the first part on."""
        ...


class Keeper(Protocol):
    """Where things of one kind are kept."""

    def __call__(self, kind: type[T], /) -> Kept[T]:
        """Return an empty place for things of this kind."""
        ...


def in_memory(kind: type[T]) -> Kept[T]:
    """Keep things of this kind in a list."""
    return list[T]()


class Whole(Protocol):
    """Something of successive shots that can be cut."""

    @property
    def count(self) -> int:
        """Number of its shots."""
        ...

    def part(self, some: slice) -> Self:
        """Return that of some successive shots."""
        ...


class Piece(Whole, Protocol):
    """Something of successive shots that can be cut and joined."""

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """Return that of shots that follow each other in parts."""
        ...


W = TypeVar("W", bound=Whole)
P = TypeVar("P", bound=Piece)


def cut(whole: W) -> Iterator[W]:
    """Yield successive shots, `SHOTS_AT_ONCE` at a time, without copying."""
    if whole.count <= SHOTS_AT_ONCE:
        yield whole
        return
    for start in range(0, whole.count, SHOTS_AT_ONCE):
        yield whole.part(slice(start, start + SHOTS_AT_ONCE))


def regrouped(pieces: Iterable[P]) -> Iterator[P]:
    """Yield the same shots in parts as `cut` makes them of the whole."""
    waiting: list[P] = []
    room = SHOTS_AT_ONCE
    for piece in pieces:
        start = 0
        while start < piece.count:
            whole = start == 0 and piece.count <= room
            own = piece if whole else piece.part(slice(start, start + room))
            waiting.append(own)
            start, room = start + own.count, room - own.count
            if room == 0:
                yield _one(waiting)
                waiting, room = [], SHOTS_AT_ONCE
    if waiting:
        yield _one(waiting)


def _one(pieces: Sequence[P]) -> P:
    return pieces[0] if len(pieces) == 1 else type(pieces[0]).joined(pieces)
