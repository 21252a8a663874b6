"""What a person says of a shot: whether it counts and why not, a note, tags."""

from __future__ import annotations

from nicegui import ui

from rigctl.page.desk import Desk, actor
from rigctl.page.parts.asking import ask_reason
from rigctl.page.parts.remarks import Remarks
from rigctl.page.parts.widgets import button
from rigctl.store import ShotRecord


class Judging:
    """Panel of one shot; whoever placed it draws it anew when the shot has changed."""

    def __init__(self, desk: Desk, shot: ShotRecord) -> None:
        self._desk, self._shot, self._store = desk, shot, desk.daemon.store
        with ui.element("div").classes("panel").props("data-testid=judging"):
            with ui.element("div").classes("title"):
                ui.label("Does it count?")
                ui.space()
                self._switch()
            if shot.excluded is not None:
                with ui.element("div").classes("verdict bad").props("data-testid=excluded"):
                    ui.label("Excluded from every fit.").classes("lead")
                    ui.label(shot.excluded)
            Remarks(
                desk,
                shot.note,
                shot.tags,
                annotate=lambda note, who: self._store.annotate(shot.id, note, who),
                tag=lambda tags, who: self._store.tag(shot.id, tags, who),
            ).place()

    def _switch(self) -> None:
        if self._shot.excluded is None:
            button("Exclude …", self._ask, testid="exclude").tooltip(
                "leaves it out of every fit; nothing of it is deleted"
            )
        else:
            button("Let it count again", self._include, testid="include")

    def _ask(self) -> None:
        async def exclude(why: str) -> bool:
            who = actor()
            done = await self._desk.act(lambda: self._store.exclude(self._shot.id, why, who))
            return done is not None

        ask_reason(
            f"Exclude shot {self._shot.number}",
            "Every fit leaves it out and names it. Frames and results stay; the reason is "
            "journalled.",
            "Exclude",
            exclude,
        )

    async def _include(self) -> None:
        who = actor()
        await self._desk.act(lambda: self._store.include(self._shot.id, who))
