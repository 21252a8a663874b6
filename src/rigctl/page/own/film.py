"""Films that were brought, in three steps: look, state the scale, measure."""

from __future__ import annotations

from nicegui import ui

from rigctl.documents import Json
from rigctl.page.desk import Desk
from rigctl.page.layout import TICK_S
from rigctl.page.own.brought import Brought
from rigctl.page.own.look import LookPanel
from rigctl.page.own.marks import unlike_words
from rigctl.page.own.measuring import MeasuringPanel
from rigctl.page.own.scale import ScaleForm
from rigctl.page.parts.following import following
from rigctl.page.parts.widgets import button


class FilmView:
    """Three steps for some films; ball, part and rate hold for all of them."""

    def __init__(self, desk: Desk, brought: Brought) -> None:
        count = len(brought.films)
        with ui.element("div").classes("columns own"):
            with ui.element("section").classes("panel"):
                self._look = LookPanel(desk, brought, self._on_marks)
            with ui.element("section").classes("panel"):
                self._form = ScaleForm(self._look)
                words = "Measure" if count == 1 else f"Measure {count} films"
                go = button(words, self._start, look="main fill", testid="own-measure")
                go.bind_enabled_from(self._form, "ready")
                ui.link("bring something else", "/own").classes("note")
        self._panel = MeasuringPanel(desk, brought, brought.films, "3 Measured")
        following(TICK_S * 2, self._follow)

    def _on_marks(self) -> None:
        self._form.refresh()

    def _follow(self) -> None:
        self._look.follow()
        self._panel.follow()

    def _start(self) -> None:
        if not self._form.ready:
            return
        marks = self._look.marks

        def remark(answer: Json) -> str | None:
            return unlike_words(marks, answer["ball"]["diameter_px"]["value"])

        self._panel.start(self._form.stated(), remark)
