"""Work on several items at a time in threads: the libraries that compute leave Python free."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import islice
from typing import TypeVar

A = TypeVar("A")
R = TypeVar("R")

VARIABLE = "RIGCTL_THREADS"
"""How many threads a process has for its films; one for each processor where it is not set."""
AHEAD = 2
"""Items for each thread that are taken before the first one's result is."""


def count() -> int:
    """Return how many threads this process computes with, one at least."""
    stated = os.environ.get(VARIABLE, "")
    return max(1, int(stated) if stated.isdecimal() else os.cpu_count() or 1)


def each(function: Callable[[A], R], items: Iterable[A]) -> Iterator[R]:
    """Give a function's result for each item, in the order of the items.

    Few items are taken ahead, so that pictures of a film are not all in memory at a time. What the
    function or the items raise is raised here, and no more is begun then.

    Examples
    --------
    >>> list(each(abs, [-1, 2, -3]))
    [1, 2, 3]
    """
    threads = count()
    if threads == 1:
        yield from map(function, items)
        return
    with ThreadPoolExecutor(threads) as pool:
        left = iter(items)
        waiting: deque[Future[R]] = deque()
        try:
            while True:
                more = islice(left, threads * AHEAD - len(waiting))
                waiting.extend(pool.submit(function, item) for item in more)
                if not waiting:
                    return
                yield waiting.popleft().result()
        finally:
            for future in waiting:
                future.cancel()
