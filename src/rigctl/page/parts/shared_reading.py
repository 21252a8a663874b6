"""What several pages ask of the disk at the same moment is read once."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from threading import Lock
from typing import TypeVar

T = TypeVar("T")


def read_once(read: Callable[[str], T], most: int) -> Callable[[str], T]:
    """Return a reader of shots whose last results are kept, and that reads one shot at a time.

    A new shot is asked for by all open pages at once, each for its film and a dozen pictures. All
    but the first wait for that one's reading; what it raises is not kept.

    Parameters
    ----------
    read
        Takes a shot's identity.
    most
        Results that are kept.
    """
    kept, turn = lru_cache(maxsize=most)(read), Lock()

    def read_in_turn(shot: str) -> T:
        with turn:
            return kept(shot)

    return read_in_turn
