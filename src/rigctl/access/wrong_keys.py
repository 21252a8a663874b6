"""Limit on wrong keys: an address that sends many waits for each answer."""

from __future__ import annotations

import asyncio
import time
from collections import OrderedDict, deque
from collections.abc import Awaitable, Callable

MANY, WITHIN_S = 10, 60.0
"""So many wrong keys in so long a time from one address, and its answers slow down."""
SHORTEST_S, LONGEST_S = 0.25, 4.0
_ADDRESSES = 1000
"""So many addresses are remembered, those that were heard last."""


class WrongKeys:
    """Counts wrong keys for one event loop; a delay holds neither a thread nor a worker.

    Parameters
    ----------
    on_many
        Called with an address once its answers slow down, and again after a pause.
    clock, sleep
        Monotonic time, s, and what waits for so long.
    """

    def __init__(
        self,
        on_many: Callable[[str], None],
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], Awaitable[object]] = asyncio.sleep,
    ) -> None:
        self._on_many, self._clock, self._sleep = on_many, clock, sleep
        self._times: OrderedDict[str, deque[float]] = OrderedDict()
        self.count = 0

    async def refuse(self, address: str) -> None:
        """Count a wrong key; return after the delay that its address has earned."""
        delay_s = self.note(address)
        if delay_s:
            await self._sleep(delay_s)

    def note(self, address: str) -> float:
        """Count a wrong key; return how long its answer has to wait, s."""
        self.count += 1
        now = self._clock()
        times = self._times.setdefault(address, deque(maxlen=2 * MANY))
        self._times.move_to_end(address)
        while len(self._times) > _ADDRESSES:
            self._times.popitem(last=False)
        while times and times[0] <= now - WITHIN_S:
            times.popleft()
        times.append(now)
        beyond = len(times) - MANY
        if beyond == 1:
            self._on_many(address)
        return min(LONGEST_S, SHORTEST_S * 2.0 ** (beyond - 1)) if beyond > 0 else 0.0
