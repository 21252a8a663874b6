"""What a person says of a shot: whether it counts and why not, a note, tags."""

from __future__ import annotations

from nicegui import ui
from pydantic import ValidationError

from rigctl.page.asking import ask_reason
from rigctl.page.desk import Desk, actor
from rigctl.page.widgets import button
from rigctl.service.models import NoteOrder, TagsOrder
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
            self._note()
            self._tags()

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

    def _note(self) -> None:
        given = ui.input("Note", value=self._shot.note or "", validation=_note_fault)
        given.props("outlined dense hide-bottom-space data-testid=note").classes("wide")

        async def keep() -> None:
            text, who = str(given.value or "").strip() or None, actor()
            if text != self._shot.note and given.validate():
                await self._desk.act(lambda: self._store.annotate(self._shot.id, text, who))

        given.on("blur", keep).on("keydown.enter", keep)

    def _tags(self) -> None:
        given = ui.input_chips("Tags", value=list(self._shot.tags), new_value_mode="add-unique")
        given.props("outlined dense data-testid=tags").classes("wide")

        async def keep() -> None:
            who = actor()
            try:
                order = TagsOrder(tags=list(given.value))
            except ValidationError as error:
                ui.notify(str(error.errors()[0]["msg"]), type="negative")
                given.set_value(list(self._shot.tags))
                return
            if tuple(sorted(order.tags)) != self._shot.tags:
                await self._desk.act(lambda: self._store.tag(self._shot.id, order.tags, who))

        given.on_value_change(keep)


def _note_fault(given: str | None) -> str | None:
    try:
        NoteOrder(note=(given or "").strip() or None)
    except ValidationError as error:
        return str(error.errors()[0]["msg"])
    return None
