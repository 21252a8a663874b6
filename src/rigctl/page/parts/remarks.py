"""Remarks on a shot or a campaign: a note, and tags."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from nicegui import ui
from pydantic import ValidationError

from rigctl.page.desk import Desk, actor
from rigctl.service.models import NoteOrder, TagsOrder


@dataclass(frozen=True, slots=True)
class Remarks:
    """A note and tags as they stand, and what changes each: both are given the actor last.

    The fields keep what is typed when they are left; whoever placed them draws them anew when
    somebody else has changed them.
    """

    desk: Desk
    note: str | None
    tags: tuple[str, ...]
    annotate: Callable[[str | None, str], object]
    tag: Callable[[Sequence[str], str], object]

    def place(self) -> None:
        """Place both fields."""
        self._note()
        self._tags()

    def _note(self) -> None:
        given = ui.input("Note", value=self.note or "", validation=_note_fault)
        given.props("outlined dense hide-bottom-space data-testid=note").classes("wide")
        before = self.note

        async def keep() -> None:
            nonlocal before
            text, who = str(given.value or "").strip() or None, actor()
            if text != before and given.validate():
                before = text
                await self.desk.act(lambda: self.annotate(text, who))

        given.on("blur", keep).on("keydown.enter", keep)

    def _tags(self) -> None:
        given = ui.input_chips("Tags", value=list(self.tags), new_value_mode="add-unique")
        given.props("outlined dense data-testid=tags").classes("wide")
        before = self.tags

        async def keep() -> None:
            nonlocal before
            who = actor()
            try:
                order = TagsOrder(tags=list(given.value))
            except ValidationError as error:
                ui.notify(str(error.errors()[0]["msg"]), type="negative")
                given.set_value(list(before))
                return
            wanted = tuple(sorted(order.tags))
            if wanted != before:
                before = wanted
                await self.desk.act(lambda: self.tag(wanted, who))

        given.on_value_change(keep)


def _note_fault(given: str | None) -> str | None:
    try:
        NoteOrder(note=(given or "").strip() or None)
    except ValidationError as error:
        return str(error.errors()[0]["msg"])
    return None
