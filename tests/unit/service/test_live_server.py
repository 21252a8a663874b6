"""Over a real socket: streams, and a stop that overtakes everything."""

from __future__ import annotations

import json
import socket
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

import fastapi.routing
import httpx
import pytest

from rigctl.rig.states import RigState
from rigctl.rig.status import Transition
from rigctl.service.events import EventHub
from rigctl.store import Store

HEADERS = {"Authorization": "Bearer a-key-for-tests"}
SETTINGS = {"pressure_a_kpa": 40, "pressure_b_kpa": 40, "offset_mm": 6}
WAIT_S = 60.0


def events_of(lines: Iterator[str]) -> Iterator[tuple[str, Any]]:
    kind = ""
    for line in lines:
        if line.startswith("event: "):
            kind = line.removeprefix("event: ")
        elif line.startswith("data: "):
            yield kind, json.loads(line.removeprefix("data: "))


def step(rig: Any, after: RigState) -> None:
    rig.listeners.notify(
        Transition(RigState.IDLE, after, rig.status().since, "tester", "because", None)
    )


@pytest.fixture
def http(address: str) -> Iterator[httpx.Client]:
    with httpx.Client(base_url=address, headers=HEADERS, timeout=WAIT_S) as client:
        yield client


def test_a_stream_begins_with_the_present_state_and_follows_the_rig(
    http: httpx.Client, rig: Any
) -> None:
    with http.stream("GET", "/api/v1/events") as answer:
        assert answer.headers["content-type"].startswith("text/event-stream")
        events = events_of(answer.iter_lines())
        kind, first = next(events)
        assert (kind, first["state"], first["before"]) == ("rig", "idle", None)
        step(rig, RigState.CHECKED)
        kind, second = next(events)
        assert (kind, second["state"], second["before"]) == ("rig", "checked", "idle")
        assert (second["actor"], second["reason"]) == ("tester", "because")


def test_a_shot_is_told_to_listeners_as_it_changes(
    http: httpx.Client, store: Store, address: str
) -> None:
    with http.stream("GET", "/api/v1/events") as answer:
        events = events_of(answer.iter_lines())
        next(events)
        with httpx.Client(base_url=address, headers=HEADERS, timeout=WAIT_S) as other:
            token = other.post("/api/v1/rig/arm", json=SETTINGS).json()["arm_token"]
            other.post("/api/v1/shots", json={"arm_token": token}, headers={"Idempotency-Key": "k"})
        kind, shot = next(events)
        assert (kind, shot["state"]) == ("shot", "accepted")


def test_a_quiet_stream_shows_that_it_lives(
    http: httpx.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fastapi.routing, "_PING_INTERVAL", 0.01)
    with http.stream("GET", "/api/v1/events") as answer:
        lines = answer.iter_lines()
        assert any(line.startswith(":") for line in lines)


def test_a_client_that_goes_away_is_forgotten(http: httpx.Client, hub: EventHub) -> None:
    with http.stream("GET", "/api/v1/events") as answer:
        events = events_of(answer.iter_lines())
        next(events)
        assert hub.clients == 1
    gone = threading.Event()
    with ThreadPoolExecutor(1) as pool:
        pool.submit(lambda: until(lambda: hub.clients == 0, gone))
        assert gone.wait(WAIT_S)


def until(condition: Callable[[], bool], reached: threading.Event) -> None:
    pause = threading.Event()
    for _ in range(1000):
        if condition():
            reached.set()
            return
        pause.wait(0.005)


def test_a_stop_overtakes_any_number_of_callers_that_wait_for_arming(
    http: httpx.Client, rig: Any, address: str
) -> None:
    rig.holds_arm = threading.Event()
    with ThreadPoolExecutor(60) as pool:
        order = partial(httpx.post, json=SETTINGS, headers=HEADERS, timeout=WAIT_S)
        waiting = [pool.submit(order, f"{address}/api/v1/rig/arm") for _ in range(60)]
        assert rig.arming.wait(WAIT_S)
        stopped = http.post("/api/v1/rig/estop", json={"reason": "now"})
        assert stopped.status_code == 200
        assert not any(call.done() for call in waiting)
        assert rig.stops[0][1] == "now"
        assert http.get("/api/v1/rig").json()["state"] == "estop"
        rig.holds_arm.set()
        assert {call.result(WAIT_S).status_code for call in waiting} == {200}


def test_a_stop_does_not_wait_for_a_body_that_never_comes(address: str, rig: Any) -> None:
    host, port = address.removeprefix("http://").split(":")
    head = b"POST /api/v1/rig/estop HTTP/1.1\r\nHost: rig\r\nContent-Length: 100\r\n\r\n{"
    with socket.create_connection((host, int(port)), timeout=WAIT_S) as line:
        line.sendall(head)
        assert line.recv(4096).startswith(b"HTTP/1.1 200")
    assert rig.stops[0][1] == "emergency stop by REST"
