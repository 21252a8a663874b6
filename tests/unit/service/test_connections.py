"""Connections beyond the limit, silent ones and slow bodies: the service goes on answering."""

from __future__ import annotations

import asyncio
import contextlib
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass
from unittest import mock
from urllib.parse import urlsplit

import httpx
import pytest

from rigctl.service import events
from rigctl.service.guards import body_limit, connections
from rigctl.service.guards.connections import Connections, GuardedHttp

Serving = Callable[[int], AbstractContextManager[str]]
BOUND_S = 60.0
HEADERS = {"Authorization": "Bearer a-key-for-tests"}


@pytest.fixture
def guarded(serving: Serving) -> Iterator[str]:
    with serving(8) as url:
        yield url


def connect(url: str) -> socket.socket:
    parts = urlsplit(url)
    return socket.create_connection((str(parts.hostname), int(parts.port or 0)), BOUND_S)


def live(url: str) -> int:
    return httpx.get(f"{url}/health/live", timeout=BOUND_S, trust_env=False).status_code


def test_where_silent_connections_fill_the_service_the_oldest_gives_way(guarded: str) -> None:
    with contextlib.ExitStack() as held:
        silent = [held.enter_context(connect(guarded)) for _ in range(12)]
        assert live(guarded) == 200
        assert silent[0].recv(1) == b""


def test_streams_that_fill_the_service_are_not_ended_for_another_caller(guarded: str) -> None:
    with contextlib.ExitStack() as held:
        clients = [
            held.enter_context(httpx.Client(base_url=guarded, headers=HEADERS, timeout=BOUND_S))
            for _ in range(8)
        ]
        streams = [held.enter_context(c.stream("GET", "/api/v1/events")) for c in clients]
        assert {stream.status_code for stream in streams} == {200}
        with pytest.raises(httpx.TransportError):
            live(guarded)
    # Those that left make room.
    done = threading.Event()
    while not done.wait(0.01):
        with contextlib.suppress(httpx.TransportError):
            assert live(guarded) == 200
            done.set()


def test_a_connection_that_asks_nothing_is_ended(
    serving: Serving, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connections, "REQUEST_WITHIN_S", 0.05)
    with serving(8) as url, connect(url) as link:
        link.sendall(b"GET /health/live HT")
        assert link.recv(1) == b""


LIVE = b"GET /health/live HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"


def answered(link: socket.socket) -> bytes:
    """Return the next answer, read to the end that its length says."""
    head = b""
    while b"\r\n\r\n" not in head:
        piece = link.recv(1)
        assert piece, head
        head += piece
    length = int(head.lower().partition(b"content-length: ")[2].split(b"\r\n")[0])
    while length:
        length -= len(link.recv(length))
    return head.split(b"\r\n")[0]


@pytest.mark.parametrize(
    ("begun", "more"),
    [
        (b"G", b""),
        (b"GET /health/live HT", b""),
        (b"\r\n", b"\r\n"),
        (LIVE[:-2] + b"X-Slow: ", b"a"),
        (LIVE + b"GET", b""),
        (LIVE[:-2] + b"Connection: upgrade\r\nUpgrade: other\r\n\r\n", b"a"),
    ],
    ids=["a letter", "a line", "empty lines", "a slow head", "behind a whole one", "an upgrade"],
)
def test_a_later_request_that_does_not_come_whole_is_ended_as_a_first_one(
    serving: Serving, monkeypatch: pytest.MonkeyPatch, begun: bytes, more: bytes
) -> None:
    monkeypatch.setattr(connections, "REQUEST_WITHIN_S", BOUND_S)
    with serving(8) as url, connect(url) as link:
        link.sendall(LIVE)
        assert b"200" in answered(link)
        monkeypatch.setattr(connections, "REQUEST_WITHIN_S", 0.3)
        link.sendall(begun)
        with trickling(link, more), contextlib.suppress(ConnectionResetError):
            while link.recv(4096):
                pass


@contextlib.contextmanager
def trickling(link: socket.socket, piece: bytes) -> Iterator[None]:
    """Send a piece again and again: whoever counts from the last byte waits for ever."""
    ended = threading.Event()

    def send() -> None:
        with contextlib.suppress(OSError):
            while not ended.wait(0.05):
                link.sendall(piece)

    thread = threading.Thread(target=send)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join(BOUND_S)


def test_a_later_body_that_trickles_is_refused_and_its_connection_ended(
    serving: Serving, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(body_limit, "BODY_WITHIN_S", 0.1)
    monkeypatch.setattr(connections, "BODY_WITHIN_S", 3.0)
    with serving(8) as url, connect(url) as link:
        link.sendall(LIVE)
        assert b"200" in answered(link)
        link.sendall(
            b"POST /api/v1/rig/arm HTTP/1.1\r\nHost: 127.0.0.1\r\n"
            b"Authorization: Bearer a-key-for-tests\r\nContent-Length: 1000\r\n\r\n{"
        )
        with trickling(link, b" "), contextlib.suppress(ConnectionResetError):
            assert b"408" in answered(link)
            while link.recv(4096):
                pass


class HandLoop:
    """Time that a test moves, and what is due in it."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self.due: list[HandTimer] = []

    def call_later(self, delay_s: float, call: Callable[[], None]) -> HandTimer:
        self.due.append(HandTimer(self.now_s + delay_s, call, self.due))
        return self.due[-1]

    def advance(self, seconds: float) -> None:
        self.now_s += seconds
        for timer in [each for each in self.due if each.at_s <= self.now_s]:
            timer.cancel()
            timer.call()


@dataclass(eq=False)
class HandTimer:
    at_s: float
    call: Callable[[], None]
    due: list[HandTimer]

    def cancel(self) -> None:
        if self in self.due:
            self.due.remove(self)


SOCKET = LIVE[:-2] + b"Connection: upgrade\r\nUpgrade: websocket\r\n\r\n"
POST = b"POST / HTTP/1.1\r\nContent-Length: 4\r\n\r\n"


@pytest.mark.parametrize(
    ("steps", "ends"),
    [
        ([(LIVE[:20], 4.0), (LIVE[20:], 60.0), (LIVE[:20], 4.9), (LIVE[20:], 60.0)], False),
        ([(LIVE, 60.0), (LIVE[:20], 3.0), (LIVE[20:30], 3.0)], True),
        ([(LIVE, 60.0), (POST + b"ab", 14.9), (b"cd", 60.0)], False),
        ([(POST + b"a", 8.0), (b"b", 8.0)], True),
        ([(LIVE, 60.0), (POST + b"a", 8.0), (b"b", 8.0)], True),
        ([(LIVE + LIVE[:9], 5.1)], True),
        ([(POST + b"abcd" + LIVE, 60.0)], False),
        ([(LIVE, 60.0), (SOCKET, 600.0)], False),
        ([(POST, 1.0), (b"abcdGET \xff", 5.1)], True),
    ],
)
def test_each_request_of_a_connection_has_its_own_time_for_head_and_body(
    monkeypatch: pytest.MonkeyPatch, steps: list[tuple[bytes, float]], ends: bool
) -> None:
    loop, transport = HandLoop(), mock.Mock(spec=asyncio.Transport)
    monkeypatch.setattr(asyncio, "get_running_loop", lambda: loop)
    guard = GuardedHttp(mock.Mock(spec=asyncio.Protocol), Connections(8))
    guard.connection_made(transport)
    for data, then_s in steps:
        guard.data_received(data)
        loop.advance(then_s)
    assert transport.close.called is ends
    guard.connection_lost(None)
    assert loop.due == []


def test_a_connection_that_only_waits_for_the_rest_of_a_later_request_gives_way(
    serving: Serving,
) -> None:
    with serving(2) as url, connect(url) as slow, connect(url) as other:
        for link in (slow, other):
            link.sendall(LIVE)
            assert b"200" in answered(link)
        slow.sendall(b"GET")
        until_live(url)
        assert slow.recv(1) == b""


def until_live(url: str) -> None:
    """Ask until the service has room: it may not have seen the last bytes of others yet."""
    for _ in range(200):
        with contextlib.suppress(httpx.TransportError):
            if live(url) == 200:
                return
    pytest.fail("there was no room")


def test_a_head_without_end_is_ended(guarded: str) -> None:
    piece = b"x" * 1_000_000
    with connect(guarded) as link, contextlib.suppress(OSError):
        link.sendall(b"GET / HTTP/1.1\r\nX-Long: ")
        # Far more than the buffers of both ends hold.
        for _ in range(200):
            link.sendall(piece)
        pytest.fail("a head of 200 MB was taken")


def test_a_body_that_does_not_come_is_refused_and_named(
    guarded: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(body_limit, "BODY_WITHIN_S", 0.05)
    with connect(guarded) as link:
        link.sendall(
            b"POST /api/v1/rig/arm HTTP/1.1\r\nHost: 127.0.0.1\r\n"
            b"Authorization: Bearer a-key-for-tests\r\nContent-Length: 100\r\n\r\n{"
        )
        assert link.recv(64).startswith(b"HTTP/1.1 408")


def test_a_stream_too_many_is_refused_with_a_sentence(
    address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(events, "MOST_CLIENTS", 1)
    with httpx.Client(base_url=address, headers=HEADERS, timeout=BOUND_S) as client:
        with client.stream("GET", "/api/v1/events") as first:
            lines = first.iter_lines()
            next(lines)
            with httpx.Client(base_url=address, headers=HEADERS, timeout=BOUND_S) as other:
                refused = other.get("/api/v1/events")
        assert (refused.status_code, refused.json()["code"]) == (503, "too-many-streams")
        assert refused.json()["limit"] == "1 streams"
