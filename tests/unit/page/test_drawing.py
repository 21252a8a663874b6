"""Pages are drawn anew one part after another, and not where a program is about to fire."""

from __future__ import annotations

import asyncio
from datetime import UTC, datetime, timedelta
from types import SimpleNamespace
from typing import Any

import pytest

from rigctl.page import desk as module
from rigctl.page.desk import Desk
from rigctl.page.feed import Feed
from rigctl.page.parts import presence
from rigctl.rig.states import RigState

PAST = timedelta(minutes=1)


def a_desk(monkeypatch: pytest.MonkeyPatch, statuses: list[tuple[RigState, timedelta]]) -> Desk:
    """Return a desk whose rig has one state after another: the last one stays."""

    def status() -> Any:
        state, ago = statuses.pop(0) if len(statuses) > 1 else statuses[0]
        return SimpleNamespace(state=state, since=datetime.now(UTC) - ago)

    client = SimpleNamespace(is_deleted=False)
    monkeypatch.setattr(module, "context", SimpleNamespace(client=client))
    monkeypatch.setattr(module, "REST_S", 0.0)
    nothing: Any = None
    daemon: Any = SimpleNamespace(rig=SimpleNamespace(status=status))
    return Desk(daemon, nothing, nothing, nothing, nothing)


def test_drawing_waits_while_the_rig_was_armed_just_now_and_while_it_fires(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = timedelta()
    states = [(RigState.ARMED, now), (RigState.FIRING, now), (RigState.CAPTURING, now)]
    desk = a_desk(monkeypatch, states)
    asyncio.run(desk.draw(lambda: None))
    assert states == [(RigState.CAPTURING, now)]


@pytest.mark.parametrize("state", [RigState.ARMED, RigState.FIRING])
def test_a_rig_that_stays_armed_holds_no_page_up(
    monkeypatch: pytest.MonkeyPatch, state: RigState
) -> None:
    drawn: list[str] = []
    asyncio.run(a_desk(monkeypatch, [(state, PAST)]).draw(lambda: drawn.append("film")))
    assert drawn == ["film"]


def test_nothing_is_drawn_between_a_fire_request_and_its_answer(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    under_way, left_when_drawn = [True, True, False], list[int]()
    monkeypatch.setattr(presence, "_rests", [lambda: under_way.pop(0)])
    desk = a_desk(monkeypatch, [(RigState.ARMED, PAST)])
    asyncio.run(desk.draw(lambda: left_when_drawn.append(len(under_way))))
    assert left_when_drawn == [0]


def test_what_all_pages_ask_of_the_store_is_read_once_after_each_change() -> None:
    feed = object.__new__(Feed)
    feed.told, feed._shared = 1, {}
    reads: list[int] = []

    def read() -> int:
        reads.append(feed.told)
        return feed.told

    assert [feed.shared("shots", read) for _ in range(3)] == [1, 1, 1]
    feed.told = 2
    assert [feed.shared("shots", read) for _ in range(3)] == [2, 2, 2]
    assert reads == [1, 2]
