"""What happens, as it happens: server-sent events."""

from __future__ import annotations

from collections.abc import AsyncIterator

from fastapi import APIRouter, Depends
from fastapi.sse import EventSourceResponse, ServerSentEvent
from starlette.concurrency import run_in_threadpool

from rigctl.daemon import Daemon
from rigctl.service.events import EventHub
from rigctl.service.models import RigEvent
from rigctl.service.problems import documented


def event_routes(daemon: Daemon, hub: EventHub) -> APIRouter:
    """Return the route `/events`."""
    router = APIRouter(tags=["events"])

    @router.get(
        "/events",
        response_class=EventSourceResponse,
        responses=documented(401, 405, 503),
        dependencies=[Depends(hub.require_room)],
    )
    async def events() -> AsyncIterator[ServerSentEvent]:
        """Stream events, each named for what it carries: `rig` (a state), `shot`, `job`, `sweep`.

        The first event is the present state. A client that falls behind is sent an event `end`
        with the reason, and no more. A comment comes every 15 s when nothing happens.
        """
        # Subscribed before the present state is read: nothing falls between the two.
        with hub.subscribe() as subscription:
            present = RigEvent.present(await run_in_threadpool(daemon.rig.status))
            yield ServerSentEvent(event="rig", data=present)
            async for event in subscription.events():
                yield event

    return router
