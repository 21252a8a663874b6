"""Connections beyond the limit, silent ones and slow bodies: the service goes on answering."""

from __future__ import annotations

import contextlib
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from urllib.parse import urlsplit

import httpx
import pytest

from rigctl.service import events
from rigctl.service.guards import body_limit, connections

Serving = Callable[[int], AbstractContextManager[str]]
BOUND_S = 10.0
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
