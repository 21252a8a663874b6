"""While a fire request is carried out no page computes anything beside it."""

from __future__ import annotations

import threading
from collections.abc import Awaitable, Callable
from types import SimpleNamespace
from typing import Any

import anyio
import pytest

from rigctl.page.parts import presence
from rigctl.service.lanes import Lanes


def test_pages_look_before_and_after_a_fire_request_and_not_within(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    timers: list[Callable[[], Awaitable[None]]] = []

    def timer(period_s: float, go: Callable[[], Awaitable[None]]) -> Any:
        timers.append(go)
        return SimpleNamespace(interval=period_s)

    client = SimpleNamespace(client=SimpleNamespace(has_socket_connection=True))
    monkeypatch.setattr(presence, "context", client)
    monkeypatch.setattr(presence, "ui", SimpleNamespace(timer=timer))
    monkeypatch.setattr(presence, "_rests", [])
    lanes, looked = Lanes(), list[str]()
    presence.rest_while(lambda: lanes.is_firing)
    presence.every(0.1, lambda: looked.append(now))
    within, answered = threading.Event(), threading.Event()

    def accept() -> str:
        within.set()
        assert answered.wait(60)
        return "a shot"

    async def fire() -> None:
        nonlocal now
        now = "before"
        await timers[0]()
        async with anyio.create_task_group() as group:
            group.start_soon(lanes.fire, accept)
            while not within.is_set():
                await anyio.sleep(0.001)
            now = "within"
            await timers[0]()
            answered.set()
        now = "after"
        await timers[0]()

    now = ""
    anyio.run(fire)
    assert looked == ["before", "after"]


def test_pages_look_again_after_a_fire_request_that_was_refused() -> None:
    lanes = Lanes()

    def refused() -> None:
        raise RuntimeError("the token does not hold")

    with pytest.raises(RuntimeError, match="does not hold"):
        anyio.run(lanes.fire, refused)
    assert not lanes.is_firing
