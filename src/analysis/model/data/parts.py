"""Campaigns taken so many shots at a time, in memory or from a file, and what is kept of each part.

A fit and a ranking go over the parts again and again and add up; only sums grow no further with
the number of shots.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol, TypeVar

from analysis.model.data.tables import Data
from analysis.model.predict.state import ShotStates

SHOTS_AT_ONCE = 256
"""So many that what is done once for each part is little, and no more than a cache holds."""

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


def parts_of(data: Data, states: ShotStates) -> Iterator[tuple[Data, ShotStates]]:
    """Return data and states of successive shots, `SHOTS_AT_ONCE` at a time, without copying."""
    for start in range(0, len(data.shots), SHOTS_AT_ONCE):
        some = slice(start, start + SHOTS_AT_ONCE)
        yield data.part(some), states.of_shots(some)
