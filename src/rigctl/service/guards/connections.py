"""Connections to the service: limits of their number, of their idle time, and of slow requests."""

from __future__ import annotations

import asyncio
import logging
import resource
from collections.abc import Callable
from typing import cast

import httptools
from uvicorn.protocols.http.auto import AutoHTTPProtocol

from rigctl.service.guards import body_limit


class Progress:
    """Follows the bytes of a caller, request after request, as the server's own parser does.

    Attributes
    ----------
    head_bytes
        Bytes of a head that is not whole yet.
    in_body
        A head is whole, and its body is not.
    """

    def __init__(self) -> None:
        # Calls the `on_` methods below.
        self._parser: httptools.HttpRequestParser | None = httptools.HttpRequestParser(self)
        self._begun = self._ended = False
        self.head_bytes = 0
        self.in_body = False

    @property
    def waits_for_head(self) -> bool:
        """Whether something of a request has come, and its head is not whole."""
        return self.head_bytes > 0

    def feed(self, data: bytes) -> None:
        """Take the next bytes.

        Bytes that no parser reads count as a head without end: between requests, behind an error,
        or behind an upgrade without a handler.
        """
        self._ended = False
        try:
            if self._parser is not None:
                self._parser.feed_data(data)
        except httptools.HttpParserUpgrade:
            self._parser, self._ended, self._begun, self.in_body = None, True, False, False
        except httptools.HttpParserError:
            self._parser, self._ended, self.in_body = None, False, False
        if self.in_body or (self._ended and not self._begun):
            self.head_bytes = 0
        else:
            self.head_bytes += len(data)

    def on_message_begin(self) -> None:
        """Note that a request begins."""
        self._begun = True

    def on_headers_complete(self) -> None:
        """Note that its head is whole."""
        self._begun, self._ended, self.in_body = False, True, True

    def on_message_complete(self) -> None:
        """Note that its body is whole too."""
        self._ended, self.in_body = True, False


_log = logging.getLogger(__name__)

MOST_CONNECTIONS = 2048
"""Connections held at once; a further one ends the one that has been idle longest."""

REQUEST_WITHIN_S = 5.0
"""A connection that has not sent the head of a request it began, or the first, is ended, s."""

BODY_WITHIN_S = body_limit.BODY_WITHIN_S + REQUEST_WITHIN_S
"""One whose body has not come whole is ended, s; before that the request is refused by name."""

SPARE_DESCRIPTORS = 512
"""Descriptors kept for devices, frames and the store."""

LONGEST_HEAD = 65_536
"""Bytes of the head of a request."""


def raise_descriptor_limit() -> int:
    """Raise the process's limit of descriptors to what connections and rig need; return it.

    A limit that the system does not let us raise is kept, and `room_for` then allows less.
    """
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    needed = MOST_CONNECTIONS + 2 * SPARE_DESCRIPTORS
    limit = needed if hard == resource.RLIM_INFINITY else min(hard, needed)
    if soft != resource.RLIM_INFINITY and soft < limit:
        resource.setrlimit(resource.RLIMIT_NOFILE, (limit, hard))
        return limit
    return soft


def room_for(descriptors: int) -> int:
    """Return how many connections a limit of descriptors leaves room for, at least 16."""
    return max(16, min(MOST_CONNECTIONS, descriptors - SPARE_DESCRIPTORS))


class Connections:
    """Every open connection of the service, the longest held first.

    Parameters
    ----------
    most
        Largest number held; a further one ends the first without a whole request, or is refused.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._open: dict[asyncio.BaseTransport, GuardedHttp] = {}

    def protocol(self) -> Callable[..., asyncio.Protocol]:
        """Return what makes a protocol for each accepted connection, as uvicorn calls it."""

        def make(**options: object) -> asyncio.Protocol:
            return GuardedHttp(AutoHTTPProtocol(**options), self)

        return make

    def admit(self, transport: asyncio.BaseTransport, held: GuardedHttp) -> bool:
        """Take a connection in; return whether there is room for it."""
        if len(self._open) >= self._most:
            self._forget_closed()
        if len(self._open) >= self._most:
            waiting = next((old for old, guard in self._open.items() if not guard.complete), None)
            if waiting is None:
                _log.warning("a connection was refused: %d are open", len(self._open))
                return False
            self._end(waiting)
        self._open[transport] = held
        return True

    def leave(self, transport: asyncio.BaseTransport) -> None:
        """Forget a connection that was lost."""
        self._open.pop(transport, None)

    def _forget_closed(self) -> None:
        """Forget those that became sockets of the page, whose end is not reported."""
        for transport in [old for old in self._open if old.is_closing()]:
            del self._open[transport]

    def _end(self, transport: asyncio.BaseTransport) -> None:
        self.leave(transport)
        transport.close()


class GuardedHttp(asyncio.Protocol):
    """One connection: the server's own protocol behind a limit of number and time.

    Each request has its time for head and body, the first as every later one. Between requests the
    server's own limit for idle connections holds; bytes that are no request do not prolong it.
    """

    def __init__(self, inner: asyncio.Protocol, connections: Connections) -> None:
        self._inner, self._connections = inner, connections
        self._transport: asyncio.Transport | None = None
        self._progress = Progress()
        self._timer: asyncio.TimerHandle | None = None
        self._limit_s: float | None = None
        self.complete = False

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Take the connection in, or end it at once."""
        link = cast("asyncio.Transport", transport)
        if not self._connections.admit(link, self):
            link.abort()
            return
        self._transport = link
        self._allow(REQUEST_WITHIN_S)
        self._inner.connection_made(transport)

    def data_received(self, data: bytes) -> None:
        """Pass data on, and note how far its request is."""
        if self._transport is None:
            return
        progress = self._progress
        progress.feed(data)
        self.complete = not progress.waits_for_head
        if progress.head_bytes > LONGEST_HEAD:
            self._transport.abort()
            return
        if progress.in_body:
            self._allow(BODY_WITHIN_S)
        else:
            self._allow(REQUEST_WITHIN_S if progress.waits_for_head else None)
        self._inner.data_received(data)

    def eof_received(self) -> bool | None:
        """Pass the end of the caller's data on."""
        return self._inner.eof_received() if self._transport is not None else None

    def pause_writing(self) -> None:
        """Pass on that the caller reads slowly."""
        self._inner.pause_writing()

    def resume_writing(self) -> None:
        """Pass on that the caller has caught up."""
        self._inner.resume_writing()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the connection."""
        self._allow(None)
        if self._transport is not None:
            self._connections.leave(self._transport)
            self._inner.connection_lost(exc)

    def _allow(self, seconds: float | None) -> None:
        """Give what comes next its time; the same time goes on where it runs already."""
        if seconds == self._limit_s:
            return
        if self._timer is not None:
            self._timer.cancel()
        self._timer, self._limit_s = None, seconds
        if seconds is not None:
            self._timer = asyncio.get_running_loop().call_later(seconds, self._end_slow)

    def _end_slow(self) -> None:
        if self._transport is not None:
            self._transport.close()
