from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable
from typing import Any

from fastapi.sse import ServerSentEvent
from pydantic import BaseModel

from rigctl.service.events import EventHub, Subscription

WAIT_S = 60.0


class Note(BaseModel):
    text: str


def run(scenario: Callable[[EventHub], Awaitable[None]], capacity: int = 4) -> None:
    asyncio.run(asyncio.wait_for(scenario(EventHub(capacity)), WAIT_S))  # type: ignore[arg-type]


async def everything(subscription: Subscription) -> list[ServerSentEvent]:
    return [event async for event in subscription.events()]


def test_events_arrive_in_order_with_rising_numbers_from_any_thread() -> None:
    async def scenario(hub: EventHub) -> None:
        with hub.subscribe() as subscription:

            def publish() -> None:
                for text in "abc":
                    hub.publish("rig", Note(text=text))
                hub.close()

            thread = threading.Thread(target=publish)
            events = subscription.events()
            first = asyncio.ensure_future(anext(events))
            thread.start()
            got = [await first, await anext(events), await anext(events)]
            thread.join(WAIT_S)
            assert [event.data.text for event in got] == ["a", "b", "c"]
            assert [event.id for event in got] == ["1", "2", "3"]

    run(scenario, capacity=8)


def test_every_client_gets_every_event() -> None:
    async def scenario(hub: EventHub) -> None:
        with hub.subscribe() as one, hub.subscribe() as two:
            hub.publish("shot", Note(text="x"))
            for subscription in (one, two):
                event = await anext(subscription.events())
                assert (event.event, event.data) == ("shot", Note(text="x"))

    run(scenario)


def test_a_client_that_falls_behind_is_told_so_and_gets_no_more() -> None:
    async def scenario(hub: EventHub) -> None:
        with hub.subscribe() as slow:
            for number in range(10):
                hub.publish("rig", Note(text=str(number)))
            (last,) = await everything(slow)
            assert last.event == "end"
            assert "4 events behind" in last.data["reason"]

    run(scenario, capacity=4)


def test_a_slow_client_takes_nothing_from_a_quick_one() -> None:
    async def scenario(hub: EventHub) -> None:
        with hub.subscribe() as _slow, hub.subscribe() as quick:
            events = quick.events()
            for number in range(20):
                hub.publish("rig", Note(text=str(number)))
                assert (await anext(events)).data.text == str(number)

    run(scenario, capacity=4)


def test_closing_ends_every_stream_with_a_word() -> None:
    async def scenario(hub: EventHub) -> None:
        with hub.subscribe() as subscription:
            hub.close()
            (last,) = await everything(subscription)
            assert (last.event, last.data) == ("end", {"reason": "the service ends"})

    run(scenario)


def test_a_client_that_left_is_forgotten() -> None:
    async def scenario(hub: EventHub) -> None:
        with hub.subscribe():
            assert hub.clients == 1
        assert hub.clients == 0
        hub.publish("rig", Note(text="nobody listens"))

    run(scenario)


def test_publishing_after_the_listeners_loop_has_ended_harms_nobody() -> None:
    hub = EventHub()
    held: list[Any] = []

    async def scenario() -> None:
        context = hub.subscribe()
        held.append(context)
        context.__enter__()

    asyncio.run(scenario())
    hub.publish("rig", Note(text="late"))
    assert hub.clients == 1
    held[0].__exit__(None, None, None)
