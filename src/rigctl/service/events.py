"""Events of the rig, its shots, sweeps and jobs, from its threads to every listening client."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import AsyncIterator, Iterator
from dataclasses import dataclass
from typing import Literal

from fastapi.sse import ServerSentEvent
from pydantic import BaseModel

from rigctl.errors import StreamsFullError

MOST_CLIENTS = 512
"""Event streams held at once; each event is packed for each of them."""

EventKind = Literal["rig", "shot", "job", "sweep"]


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened; `number` rises by one for each."""

    number: int
    kind: EventKind
    data: BaseModel


@dataclass(frozen=True, slots=True)
class _End:
    """The last word to a client."""

    reason: str


class Subscription:
    """Events on their way to one client, at most `capacity` of them."""

    def __init__(self, capacity: int) -> None:
        self._loop = asyncio.get_running_loop()
        self._waiting: asyncio.Queue[Event | _End] = asyncio.Queue(capacity)
        self._ended = False

    async def events(self) -> AsyncIterator[ServerSentEvent]:
        """Yield events as they come, and a last one named `end` with the reason of the end."""
        while isinstance(item := await self._waiting.get(), Event):
            yield ServerSentEvent(event=item.kind, id=str(item.number), data=item.data)
        yield ServerSentEvent(event="end", data={"reason": item.reason})

    def hand(self, item: Event | _End) -> None:
        """Pass an item on from any thread."""
        # The loop is closed when the service has ended: then there is no listener.
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._take, item)

    def _take(self, item: Event | _End) -> None:
        if self._ended:
            return
        if self._waiting.full():
            behind = self._waiting.qsize()
            item = _End(f"dropped: {behind} events behind; connect again for the present state")
            while not self._waiting.empty():
                self._waiting.get_nowait()
        self._ended = isinstance(item, _End)
        self._waiting.put_nowait(item)


class EventHub:
    """Spreads events to subscriptions; a slow client is dropped and never slows the rig.

    `publish` and `close` may be called from any thread, `subscribe` from an event loop.
    """

    def __init__(self, capacity: int = 64) -> None:
        self._capacity = capacity
        self._lock = threading.Lock()
        self._subscriptions: set[Subscription] = set()
        self._published = 0

    def publish(self, kind: EventKind, data: BaseModel) -> None:
        """Give an event to every client; returns at once."""
        with self._lock:
            self._published += 1
            event = Event(self._published, kind, data)
            for subscription in self._subscriptions:
                subscription.hand(event)

    @contextlib.contextmanager
    def subscribe(self) -> Iterator[Subscription]:
        """Open a subscription for the length of a `with` block."""
        subscription = Subscription(self._capacity)
        with self._lock:
            self._subscriptions.add(subscription)
        try:
            yield subscription
        finally:
            with self._lock:
                self._subscriptions.discard(subscription)

    @property
    def clients(self) -> int:
        """How many subscriptions are open."""
        with self._lock:
            return len(self._subscriptions)

    def require_room(self) -> None:
        """Refuse a client beyond `MOST_CLIENTS`.

        Raises
        ------
        StreamsFullError
            So many listen already.
        """
        if self.clients >= MOST_CLIENTS:
            raise StreamsFullError(
                "no further event stream is given",
                value=f"{self.clients} streams",
                limit=f"{MOST_CLIENTS} streams",
                todo="close some, or ask GET /api/v1/rig instead",
            )

    def close(self) -> None:
        """Send the end of the service to every client."""
        with self._lock:
            for subscription in self._subscriptions:
                subscription.hand(_End("the service ends"))
