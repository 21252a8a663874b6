"""What every page works with: the daemon, its threads, and what happened last."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from threading import Event
from typing import TypeVar

from nicegui import context, ui

from rigctl.daemon import Daemon
from rigctl.errors import RigError
from rigctl.model import FUNCTIONS
from rigctl.page.feed import Feed
from rigctl.page.parts.presence import is_late, resting
from rigctl.page.parts.readings import Readings
from rigctl.page.shots.films import Films
from rigctl.rig.states import RigState
from rigctl.service.lanes import Lanes

T = TypeVar("T")
REST_S = 0.02
"""Between two parts of pages that are drawn anew."""
NEAR_FIRE, NEAR_S = frozenset({RigState.ARMED, RigState.FIRING}), 0.5
"""States in which drawing waits, and how long of each, s. Programs fire as soon as they have armed;
people take longer, and see the last shot meanwhile."""
TOO_LATE = (
    "Not done: it was pressed while the page had no connection. See how the rig stands, and press "
    "it again."
)


@dataclass(frozen=True, slots=True)
class Desk:
    """The daemon as the pages see it.

    Attributes
    ----------
    lanes
        Threads for what blocks: a stop never waits for an arming.
    feed
        What happened last.
    readings
        What shots were measured to be.
    films
        What of a shot's folder is shown.
    pencil
        Whose turn it is to draw.
    """

    daemon: Daemon
    lanes: Lanes
    feed: Feed
    readings: Readings
    films: Films
    pencil: asyncio.Lock = field(default_factory=asyncio.Lock)
    _prepared: Event = field(default_factory=Event)

    def prepare(self) -> None:
        """Have processes load what the first shot and the first fit need; only once, at once.

        Who opens a page will ask for one of them, and is spared the loading.
        """
        if not self._prepared.is_set():
            self._prepared.set()
            self.daemon.prepare_analysis()
            self.daemon.jobs.prepare(FUNCTIONS)

    async def draw(self, part: Callable[[], object]) -> None:
        """Draw a part of a page anew when it is its turn; a page that was left is not drawn.

        However many pages are open, requests come in between: a fire request waits for one part of
        one page at most, and for none where it comes as soon as the rig is armed.
        """
        client = context.client
        async with self.pencil:
            while resting() or self._fire_is_near():
                await asyncio.sleep(REST_S)
            if not client.is_deleted:
                part()
                await asyncio.sleep(REST_S)

    def _fire_is_near(self) -> bool:
        """Say whether a program may be about to fire, or the rig fires; neither lasts for long."""
        rig = self.daemon.rig.status()
        for_s = (datetime.now(UTC) - rig.since).total_seconds()
        return rig.state in NEAR_FIRE and 0.0 <= for_s < NEAR_S

    async def act(
        self, call: Callable[[], T], *, moves: bool = False, fires: bool = False
    ) -> T | None:
        """Run what moves the rig or writes; a refusal is shown in its own words and gives None.

        What `moves` the rig is not done if it may have been pressed before the page lost its
        connection: nobody may be surprised by a rig that arms minutes later. While one `fires` all
        pages rest.
        """
        client = context.client
        if moves and is_late(client):
            ui.notify(TOO_LATE, type="warning", timeout=12_000)
            return None
        try:
            return await (self.lanes.fire(call) if fires else self.lanes.control(call))
        except RigError as error:
            with client:
                ui.notify(error.sentence(), type="negative", multi_line=True, timeout=12_000)
            return None

    async def done(self, call: Callable[[], None], *, moves: bool = False) -> bool:
        """Run what gives no answer, as `act`; say whether it was done."""

        def work() -> bool:
            call()
            return True

        return bool(await self.act(work, moves=moves))

    async def stop(self, by: str) -> None:
        """Stop the rig at once; `by` says how."""
        client, who = context.client, actor()
        try:
            await self.lanes.stop(lambda: self.daemon.rig.estop(who, f"stopped by {by}"))
        except RigError as error:
            with client:
                ui.notify(error.sentence(), type="negative", multi_line=True, timeout=0)


def actor() -> str:
    """Return the name under which the rig journals what this browser does."""
    client = context.client
    holder = getattr(client.request.state, "holder", "page")
    return f"{holder} on page {client.id[:8]} at {client.ip or 'unknown'}"
