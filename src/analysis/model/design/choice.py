"""Shots chosen one after another, each where it tells most, and exchanged at the end."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from analysis.arrays import Floats

_EXCHANGES, _TURNS = 50, 3
_BETTER = 1e-9


class Aim(Protocol):
    """What a design is good for."""

    @property
    def size(self) -> int:
        """Number of settings K that can be chosen."""

    def worth(self, counts: Floats) -> float:
        """Return what a design is worth, to be as large as possible; counts of shape (K,)."""

    def worth_with(self, counts: Floats) -> Floats:
        """Return the same for the design with one more shot at each setting, shape (K,)."""


def chosen(
    aim: Aim, enough: Callable[[Floats], bool], most: int, start: Floats | None = None
) -> Floats:
    """Return how many shots to fire at each setting, shape (K,): as few as are enough.

    Greedy with replacement, then exchange: shots move for as long as the design gains, and the
    least useful one goes for as long as the rest is enough (V. V. Fedorov, Theory of Optimal
    Experiments (1972), chapter 3).

    Parameters
    ----------
    enough
        Whether a design does what is asked.
    most
        No more shots than this; a design that is not enough is returned as it then stands.
    start
        Design to begin with; None: no shot.
    """
    counts = np.zeros(aim.size) if start is None else start
    for _ in range(_TURNS):
        counts = exchanged(aim, _filled(aim, enough, most, counts))
        # What an exchange gains may not be what is asked for.
        if enough(counts) or counts.sum() >= most:
            break
    else:
        counts = _filled(aim, enough, most, counts)
    while counts.sum() > 0 and enough(counts):
        fewer = exchanged(aim, _without_least(aim, counts))
        if not enough(fewer):
            break
        counts = fewer
    return counts


def fewest_even(size: int, enough: Callable[[Floats], bool], most: int) -> int | None:
    """Return how many shots are enough that are spread evenly over all K settings.

    None: more than `most`.
    """
    flat = np.full(size, 1.0 / size)
    if not enough(most * flat):
        return None
    low, high = -1, most
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if enough(middle * flat) else (middle, high)
    return high


def exchanged(aim: Aim, counts: Floats) -> Floats:
    """Move one shot at a time to where it is worth more, until none is."""
    worth = aim.worth(counts)
    for _ in range(_EXCHANGES):
        gains = []
        for k in np.flatnonzero(counts):
            left = _less(counts, int(k))
            offered = aim.worth_with(left)
            best = int(offered.argmax())
            gains.append((float(offered[best]), int(k), best))
        if not gains:
            break
        value, taken, put = max(gains)
        if value <= worth * (1 + np.sign(worth) * _BETTER) or taken == put:
            break
        counts, worth = _less(counts, taken), value
        counts[put] += 1
    return counts


def _filled(aim: Aim, enough: Callable[[Floats], bool], most: int, counts: Floats) -> Floats:
    """Add shots where each is worth most, until there are enough.

    Whether a design is enough costs far more than its next shot, and more shots are never less:
    numbers of shots are doubled until they are enough, and the fewest is found by halving.
    """
    if counts.sum() >= most or enough(counts):
        return counts.copy()
    designs, short, step = [counts.copy()], 0, 1
    while True:
        room = int(most - counts.sum())
        while len(designs) <= min(step, room):
            more = designs[-1].copy()
            more[int(aim.worth_with(more).argmax())] += 1
            designs.append(more)
        reached = len(designs) - 1
        if enough(designs[reached]):
            break
        if reached == room:
            return designs[reached]
        short, step = reached, 2 * step
    while reached - short > 1:
        middle = (short + reached) // 2
        short, reached = (short, middle) if enough(designs[middle]) else (middle, reached)
    return designs[reached]


def _without_least(aim: Aim, counts: Floats) -> Floats:
    used = np.flatnonzero(counts)
    left = [_less(counts, int(k)) for k in used]
    return max(left, key=aim.worth)


def _less(counts: Floats, k: int) -> Floats:
    fewer = counts.copy()
    fewer[k] -= 1
    return fewer
