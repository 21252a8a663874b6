"""How fast a sweep goes, and how long it will still take."""

from __future__ import annotations

from collections import deque

REMEMBERED = 16
"""Steps over which the pace is averaged: enough to be steady, few enough to follow a change."""


class Pace:
    """Mean time from the end of one step to the end of the next, s."""

    def __init__(self, began: float) -> None:
        self._ended: deque[float] = deque([began], maxlen=REMEMBERED + 1)

    def step_ended(self, at: float) -> None:
        """Note the monotonic time (s) at which a step ended."""
        self._ended.append(at)

    def left_s(self, steps: int) -> float | None:
        """Return how long so many steps will take, s; None before the first has ended."""
        cycles = len(self._ended) - 1
        if cycles == 0:
            return None
        return steps * (self._ended[-1] - self._ended[0]) / cycles
