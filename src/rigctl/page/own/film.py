"""Films that were brought: looked at, scale and part stated, measured one by one, handed back."""

from __future__ import annotations

import shutil

from nicegui import ui

from rigctl.documents import Json
from rigctl.jobs import Job, in_process
from rigctl.page.desk import Desk
from rigctl.page.layout import TICK_S
from rigctl.page.model.state import Question
from rigctl.page.own.brought import CAMPAIGN, FIGURE, MEASURED, RESULT, Brought
from rigctl.page.own.look import FUNCTIONS, LookPanel
from rigctl.page.own.marks import unlike_words
from rigctl.page.own.measured import MeasuredFilms
from rigctl.page.own.scale import ScaleForm
from rigctl.page.parts.following import following
from rigctl.page.parts.waiting import Waiting
from rigctl.page.parts.widgets import button


class FilmView:
    """Three steps for some films; ball, part and rate hold for all of them."""

    def __init__(self, desk: Desk, brought: Brought) -> None:
        self._desk, self._brought = desk, brought
        self._measuring = 0
        self._results: dict[int, Json] = {}
        self._failures: dict[int, str] = {}
        self._measure = Question(self._ask_measure, desk.daemon.jobs.job)
        with ui.element("div").classes("columns own"):
            with ui.element("section").classes("panel"):
                self._look = LookPanel(desk, brought, self._on_marks)
            with ui.element("section").classes("panel"):
                self._form = ScaleForm(self._look)
                self._go()
        with ui.element("section").classes("panel").props("data-testid=own-result"):
            Waiting(desk, "Measuring", lambda: self._measure.running or "", "measuring")
            self._measured()
        following(TICK_S * 2, self._follow)

    def _on_marks(self) -> None:
        self._form.refresh()

    def _go(self) -> None:
        count = len(self._brought.films)
        words = "Measure" if count == 1 else f"Measure {count} films"
        go = button(words, self._start, look="main fill", testid="own-measure")
        go.bind_enabled_from(self._form, "ready")
        ui.link("bring something else", "/own").classes("note")

    def _follow(self) -> None:
        self._look.follow()
        if self._measure.follow():
            self._keep()
            self._measured.refresh()

    def _keep(self) -> None:
        """Keep what came of a film, and go on with the next one unless a person ended it."""
        number = self._measuring
        answer = self._measure.answer
        if answer is not None:
            self._results[number] = answer
            unlike = unlike_words(self._look.marks, answer["ball"]["diameter_px"]["value"])
            answer["notes"] += [unlike] if unlike else []
        else:
            self._failures[number] = self._measure.failure
        if number + 1 < len(self._brought.films) and not self._measure.cancelled:
            self._measuring = number + 1
            self._measure.start()

    def _start(self) -> None:
        shutil.rmtree(self._brought.folder / MEASURED, ignore_errors=True)
        (self._brought.folder / MEASURED).mkdir()
        self._results, self._failures, self._measuring = {}, {}, 0
        self._measure.start()
        self._measured.refresh()

    @ui.refreshable_method
    def _measured(self) -> None:
        ui.html("3 Measured", sanitize=False, tag="h3").classes("card-heading")
        names = [path.name for path in self._brought.films]
        current = None if self._measure.running is None else self._measuring
        MeasuredFilms(
            self._desk, self._brought, names, self._results, self._failures, current
        ).place()

    def _ask_measure(self) -> Job:
        folder, number = self._brought.folder / MEASURED, self._measuring
        films = self._brought.films
        asked = {
            "path": str(films[number]),
            "shot": number + 1,
            "name": films[number].name,
            "title": films[0].name,
            **self._form.stated(),
            "figure": str(folder / f"{FIGURE}-{number + 1}.png"),
            "result": str(folder / f"{RESULT}-{number + 1}.json"),
            "earlier": [str(folder / f"{RESULT}-{done + 1}.json") for done in self._results],
            "campaign": str(folder / CAMPAIGN),
        }
        work = in_process(f"{FUNCTIONS}:measure_job", asked)
        return self._desk.daemon.jobs.submit("film", films[number].name, work)
