"""Which of many stops are written one by one: a caller who repeats them fills no catalogue."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

MOST = 5
WITHIN_S = 10.0
"""Further stops of a stopped rig: so many within this time are written, the rest counted."""


class RepeatedStops:
    """Counts the stops that came after the first; the caller guards every call by one lock.

    Parameters
    ----------
    monotonic
        Time in s.
    """

    def __init__(self, monotonic: Callable[[], float]) -> None:
        self._monotonic = monotonic
        self._written: deque[float] = deque(maxlen=MOST)
        self._counted = 0

    def is_written(self) -> bool:
        """Say whether this stop is written; it is counted where it is not."""
        now = self._monotonic()
        if len(self._written) == MOST and now - self._written[0] < WITHIN_S:
            self._counted += 1
            return False
        self._written.append(now)
        return True

    def take_count(self) -> int:
        """Return how many were counted and not written, and begin anew."""
        counted, self._counted = self._counted, 0
        return counted
