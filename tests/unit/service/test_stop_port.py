"""The stop's own port: it answers one thing, to everybody, whatever else is sent to it."""

from __future__ import annotations

import contextlib
import resource
import socket
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import httpx
import pytest

from rigctl.errors import DeviceSilentError
from rigctl.rig.states import RigState
from rigctl.service import stop_port
from rigctl.service.guards.origins import OwnOrigins
from rigctl.service.stop_port import StopPort

BOUND_S = 60.0


@dataclass
class SlowRig:
    """A rig whose stop waits until the test lets it end."""

    rig: Any
    go_on: threading.Event = field(default_factory=threading.Event)
    reached: threading.Event = field(default_factory=threading.Event)
    refusal: Exception | None = None

    def estop(self, actor: str, reason: str) -> None:
        self.rig.estop(actor, reason)
        self.reached.set()
        assert self.go_on.wait(BOUND_S)
        if self.refusal is not None:
            raise self.refusal

    def status(self) -> Any:
        return self.rig.status()


@pytest.fixture
def slow(rig: Any) -> SlowRig:
    found = SlowRig(rig)
    found.go_on.set()
    return found


@pytest.fixture
def port(slow: SlowRig) -> Iterator[int]:
    listening = socket.create_server(("127.0.0.1", 0))
    number = int(listening.getsockname()[1])
    opened = StopPort(listening, slow, OwnOrigins())
    yield number
    opened.close()


def stop(port: int, path: str = "/api/v1/rig/estop", **options: Any) -> httpx.Response:
    url = f"http://127.0.0.1:{port}{path}"
    return httpx.post(url, timeout=BOUND_S, trust_env=False, **options)


@pytest.mark.parametrize("path", ["/", "/api/v1/rig/estop"])
def test_a_post_without_a_key_stops_the_rig_and_shows_its_state(
    port: int, rig: Any, path: str
) -> None:
    answer = stop(port, path, json={"reason": "smoke"})
    assert (answer.status_code, answer.json()["state"]) == (200, RigState.ESTOP)
    assert rig.stops == [("no key at 127.0.0.1", "smoke")]


@pytest.mark.parametrize("body", [b"", b"{", b"\xff\xfe", b'{"reason": 1}', b"[" * 10_000])
def test_no_body_is_bad_enough_to_refuse_a_stop(port: int, rig: Any, body: bytes) -> None:
    assert stop(port, content=body).status_code == 200
    assert [reason for _, reason in rig.stops] == ["emergency stop by REST"]


def test_a_body_that_never_comes_is_not_waited_for(port: int, rig: Any) -> None:
    with socket.create_connection(("127.0.0.1", port), BOUND_S) as link:
        link.sendall(b"POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 9000\r\n\r\n")
        assert link.recv(64).startswith(b"HTTP/1.1 200")
    assert len(rig.stops) == 1


def test_another_page_cannot_stop_the_rig(port: int, rig: Any) -> None:
    assert stop(port, headers={"Origin": "http://evil.example"}).status_code == 403
    assert stop(port, headers={"Host": "evil.example"}).status_code == 403
    assert rig.stops == []


def test_nothing_else_is_answered(port: int, rig: Any) -> None:
    assert stop(port, "/api/v1/rig/release").status_code == 405
    assert httpx.get(f"http://127.0.0.1:{port}/", trust_env=False).status_code == 200
    assert rig.stops == []


def test_a_stop_that_fails_says_so(port: int, slow: SlowRig) -> None:
    slow.refusal = DeviceSilentError("could not be cut", part="cut-off")
    answer = stop(port)
    assert (answer.status_code, answer.json()["code"]) == (503, "device-silent")
    slow.refusal = ZeroDivisionError()
    assert stop(port).json()["code"] == "internal"
    slow.refusal = None
    assert stop(port).status_code == 200


def test_callers_that_come_during_a_stop_are_answered_by_the_next_one_together(
    port: int, slow: SlowRig, rig: Any
) -> None:
    slow.go_on.clear()
    answers: list[int] = []
    callers = [
        threading.Thread(target=lambda: answers.append(stop(port).status_code)) for _ in range(10)
    ]
    callers[0].start()
    assert slow.reached.wait(BOUND_S)
    for caller in callers[1:]:
        caller.start()
    slow.go_on.set()
    for caller in callers:
        caller.join(BOUND_S)
    assert answers == [200] * 10
    assert 1 <= len(rig.stops) <= 10


def test_silent_connections_do_not_keep_a_stop_out(port: int, rig: Any) -> None:
    with contextlib.ExitStack() as held:
        for _ in range(3 * stop_port.MOST_CONNECTIONS):
            held.enter_context(socket.create_connection(("127.0.0.1", port), BOUND_S))
        assert stop(port).status_code == 200
    assert len(rig.stops) == 1


def test_a_process_without_a_free_descriptor_still_takes_a_stop(port: int, rig: Any) -> None:
    with contextlib.ExitStack() as held, descriptors_for_us_alone():
        link = held.enter_context(socket.create_connection(("127.0.0.1", port), BOUND_S))
        with contextlib.suppress(OSError):
            while True:
                held.enter_context(socket.socket())
        link.sendall(b"POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 0\r\n\r\n")
        assert link.recv(64).startswith(b"HTTP/1.1 200")
    assert len(rig.stops) == 1


@contextlib.contextmanager
def descriptors_for_us_alone() -> Iterator[None]:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(soft, 512), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def test_what_is_no_http_is_let_go_and_the_port_goes_on(port: int, rig: Any) -> None:
    for noise in (b"\x16\x03\x01\x02\x00", b"GET\r\n\r\n", b"POST / HTTP/1.1\r\n" + b"x" * 200_000):
        with (
            contextlib.suppress(OSError),
            socket.create_connection(("127.0.0.1", port), BOUND_S) as link,
        ):
            link.sendall(noise)
            link.shutdown(socket.SHUT_WR)
            while link.recv(4096):
                pass
    assert stop(port).status_code == 200
    assert len(rig.stops) == 1
