"""Threads for calls that block, so that none of them holds up the event loop or the stop."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import anyio
from anyio import to_thread

T = TypeVar("T")


class Lanes:
    """Two sets of threads: one for calls that move the rig, one for the emergency stop alone.

    Arming waits seconds for pressure and slide. However many callers wait for that, a stop finds
    a free thread, and so do readers, whose threads are again others.
    """

    def __init__(self) -> None:
        self._control = anyio.CapacityLimiter(4)
        self._stop = anyio.CapacityLimiter(32)
        self._firing = 0

    @property
    def is_firing(self) -> bool:
        """Whether a fire request has come in that is not answered yet: all that can wait rests."""
        return self._firing > 0

    async def fire(self, call: Callable[[], T]) -> T:
        """Run a fire request, as `control`."""
        self._firing += 1
        try:
            return await self.control(call)
        finally:
            self._firing -= 1

    async def control(self, call: Callable[[], T]) -> T:
        """Run a call that moves the rig; further callers wait for a free thread."""
        return await to_thread.run_sync(call, limiter=self._control)

    async def stop(self, call: Callable[[], T]) -> T:
        """Run the emergency stop, at once."""
        return await to_thread.run_sync(call, limiter=self._stop)
