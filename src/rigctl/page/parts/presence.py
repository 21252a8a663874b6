"""Pages without a connection: they are kept, rest meanwhile, and come back to what is true."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Awaitable, Callable, Coroutine
from contextlib import suppress
from typing import Any

from nicegui import Client, context, ui

KEPT_S = 600.0
"""A page without a connection is kept for so long, with whatever was typed in it. A host, a
network or a browser that is busy for a while comes back to the page that it had."""
UNSEEN_S = 1.0
"""How often a page without a connection looks whether it has one."""
ECHO = "view"
"""A property of the page's layout, asked of the browser only for its answer: it sends whatever
waited for the connection before that."""
ECHO_S = 30.0
POLL_S = 0.02

_rests: list[Callable[[], bool]] = []
"""What says that all pages rest."""

_coming_back: Counter[str] = Counter()
"""How many answers are waited for, by the client's name."""


def kept_page(path: str) -> ui.page:
    """Register a page that is kept for `KEPT_S` after its connection was lost."""
    return ui.page(path, reconnect_timeout=KEPT_S)


def rest_while(*fires: Callable[[], bool]) -> None:
    """Have no page look at anything while one of these is true; replaces what was said before."""
    _rests[:] = fires


def resting() -> bool:
    """Say whether all pages rest: a fire request has come in that is not answered yet."""
    return any(fires() for fires in _rests)


def every(period_s: float, look: Callable[[], Awaitable[None] | None]) -> None:
    """Call `look` again and again; while the page has no connection nobody looks.

    Nor does anybody while pages rest: what a page computes would be done beside a fire request, in
    the same interpreter, before the trigger has its bytes.
    """
    client = context.client

    async def go() -> None:
        timer.interval = period_s if client.has_socket_connection else UNSEEN_S
        if not client.has_socket_connection or resting():
            return
        if (waits := look()) is not None:
            await waits

    timer = ui.timer(period_s, go)


def come_back() -> None:
    """Have this page show what is true, and do nothing that is old, when its connection is back."""
    client = context.client
    known = False

    def connected() -> Coroutine[Any, Any, None] | None:
        nonlocal known
        again, known = known, True
        if not again:
            return None
        _coming_back[client.id] += 1
        return _after(_held(client), client)

    client.on_connect(connected)
    client.on_delete(lambda: _coming_back.pop(client.id, None))


def is_late(client: Client) -> bool:
    """Say whether what comes in now may have been pressed while there was no connection."""
    return _coming_back[client.id] > 0


def _held(client: Client) -> dict[int, Any]:
    """Hold what has changed since until what was lost on its way is sent; return both.

    The page library sends changes first and repeats lost messages afterwards: an older state would
    stand on the page until it changes again.
    """
    outbox = client.outbox
    lost = [data for _, kind, data in outbox.messages if kind == "update"]
    if not lost:
        return {}
    there = {key: client.elements[key] for data in lost for key in data if key in client.elements}
    held = {**there, **outbox.updates}
    outbox.updates.clear()
    return held


async def _after(held: dict[int, Any], client: Client) -> None:
    outbox = client.outbox
    while outbox.messages and not client.is_deleted:
        await asyncio.sleep(POLL_S)
    for key, element in held.items():
        outbox.updates.setdefault(key, element)
    with suppress(TimeoutError):
        await client.layout.get_computed_prop(ECHO, timeout=ECHO_S)
        # What came before the answer is under way by then.
        await asyncio.sleep(POLL_S)
    if client.id in _coming_back:
        _coming_back[client.id] -= 1
