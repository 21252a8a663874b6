"""The four steps side by side: panels that stay, in which each answer is drawn."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nicegui import ui

from rigctl.page.desk import Desk
from rigctl.page.model.compare import compare
from rigctl.page.model.missing import missing
from rigctl.page.model.path import GrownPath
from rigctl.page.model.state import Effects, ModelState
from rigctl.page.model.where import Where

Json = dict[str, Any]


class Steps:
    """Compare, where it fails, what is missing, error path; nothing before the first answer.

    `take` has the model taken with other effects. `last` is where more can be placed after them.
    """

    def __init__(self, desk: Desk, state: ModelState, take: Callable[[Effects], None]) -> None:
        self._desk, self._state, self._take = desk, state, take
        self._shown: Json = {}
        self._due = False
        # In the order in which they are read: in rows, or in one column on a tablet.
        with ui.element("div").classes("columns model nothing") as self._all:
            self._first, self._second, self._offered = (ui.element("div") for _ in range(3))
            self.last = ui.element("div").classes("stack")
            with self.last:
                self._fourth = ui.element("div")
        self.show()

    def show(self) -> None:
        """Draw the latest answer on the way to the present effects."""
        known = self._state.path()
        if not known:
            return
        shown, before = self._state.present or known[-1], self._shown
        self._shown = shown
        if not before:
            self._build()
            return
        if shown is not before:
            self._compared.refresh()
            # A plot that is drawn over costs half of one that is made anew.
            self._where.show(shown)
            self._due = True
        self._path.show()
        self._hold()

    def rank(self) -> None:
        """Draw the ranking of the answer that `show` drew, once the browser has begun with that.

        It is a third of all that is drawn, and what was asked is answered above it.
        """
        if self._due:
            self._due = False
            self._ranked.refresh()
            self._hold()

    def _build(self) -> None:
        self._all.classes(remove="nothing")
        with self._first:
            self._compared()
        with self._second:
            self._where = Where(self._desk, self._state, self._shown)
        with self._offered:
            self._ranked()
        with self._fourth:
            self._path = GrownPath(self._state, self._take)
        self._hold()

    def _hold(self) -> None:
        """Let no effect be added from a ranking that is not that of the present effects."""
        waiting = self._due or self._state.present is None
        self._offered.props(add="inert" if waiting else None, remove=None if waiting else "inert")

    @ui.refreshable_method
    def _compared(self) -> None:
        compare(self._shown)

    @ui.refreshable_method
    def _ranked(self) -> None:
        missing(self._shown, self._add)

    def _add(self, name: str) -> None:
        self._take((*self._state.effects, name))
