"""Bring your own: drop a film or a campaign, look, say how large the ball is, measure, compare."""

from __future__ import annotations

import shutil
from collections.abc import Sequence

from nicegui import ui

from rigctl.documents import Json
from rigctl.errors import RigError
from rigctl.jobs import Job, in_process
from rigctl.page.desk import Desk
from rigctl.page.layout import TICK_S, sheet
from rigctl.page.model.source import Source
from rigctl.page.model.state import Question
from rigctl.page.own.brought import (
    CAMPAIGN,
    FIGURE,
    MEASURED,
    RESULT,
    Brought,
    brought_before,
    known,
)
from rigctl.page.own.dropping import SHOWN_AT, drop_field
from rigctl.page.own.look import FUNCTIONS, LookPanel
from rigctl.page.own.marks import Marks, diameter_by_line, scale_words, unlike_words, window_of
from rigctl.page.own.measured import MeasuredFilms
from rigctl.page.own.table import TableView
from rigctl.page.parts.fields import OptionalNumber
from rigctl.page.parts.following import following
from rigctl.page.parts.presence import kept_page
from rigctl.page.parts.waiting import Waiting
from rigctl.page.parts.widgets import button

Range = tuple[float, float, str]
"""Least, most, and their unit."""
DIAMETERS, MASSES = (0.1, 2000.0, "mm"), (1e-6, 1e6, "g")
RATES, LENGTHS = (0.1, 1e8, ""), (0.1, 1e5, "mm")
"""What may be stated of a ball, its camera and a line over a known length."""


class ScaleForm:
    """Diameter, stated or by a line over a known length; mass and rate; the part, in words.

    Attributes
    ----------
    ready
        Whether the ball's diameter is known, and a frame rate.
    """

    def __init__(self, look: LookPanel) -> None:
        self._look = look
        self.ready = False
        ui.html("2 Scale and part", sanitize=False, tag="h3").classes("card-heading")
        # Mass and rate stand below the words on the marks, and follow when they are there.
        self._fields: list[OptionalNumber] = []
        self._diameter = _number(
            "Diameter of the ball, mm", "ball-diameter-mm", "the scale", DIAMETERS
        )
        self._marked()
        self._mass = _number(
            "Its mass, g (if known)", "ball-mass-g", "then the air's drag is known", MASSES
        )
        self._rate = _number("Frames a second, if not the file's", "fps", "of the camera", RATES)
        self._fields = [self._diameter, self._mass, self._rate]
        ui.label("All speeds follow from the frame rate; the fall of the ball checks it.").classes(
            "note"
        )
        self._diameter.field.on_value_change(self.refresh)
        self._mass.field.on_value_change(self.refresh)
        self._rate.field.on_value_change(self._rated)

    def refresh(self) -> None:
        """Follow the marks and the fields."""
        self._marked.refresh()

    def stated(self) -> Json:
        """Return what is stated, as a measurement asks for it."""
        by_line = diameter_by_line(self._look.marks, self._length_mm)
        known = self._diameter.value
        part, size = self._look.marks.part, self._look.size
        return {
            "diameter_mm": known or (by_line.value if by_line else None),
            "diameter_sigma": 0.0 if known or not by_line else by_line.sigma / by_line.value,
            "mass_g": self._mass.value,
            "rate_hz": self._rate.value,
            "window": list(window_of(part, size)) if part and size else None,
        }

    _length_mm: float | None = None
    _rate_hz: float | None = None

    @ui.refreshable_method
    def _marked(self) -> None:
        marks = self._look.marks
        by_line = diameter_by_line(marks, self._length_mm)
        known = self._diameter.value
        lacks_rate = self._look.unrated and not self._rate_hz
        valid = all(field.valid for field in self._fields)
        self.ready = bool(known or by_line) and not lacks_rate and valid
        ui.label(scale_words(marks, known, by_line)).classes("note").props(
            "data-testid=scale-words role=status"
        )
        if lacks_rate:
            ui.label("The file states no frame rate: fill in that of the camera.").classes(
                "note"
            ).props("data-testid=no-rate role=status")
        if by_line is not None and known is None:
            ui.label(f"By the line the ball is {by_line.concise()} mm across.").props(
                "data-testid=by-line"
            )
        with ui.element("div").classes("beside"):
            words = "Take the line away" if marks.line else "Draw a line over a known length"
            button(words, self._look.draw_line, testid="draw-line")
            if marks.ring is None and self._look.size is not None:
                button("Put a ring on the ball", self._look.draw_ring, testid="draw-ring")
            if marks.part is not None:
                button("Look at all of the picture", self._look.take_all, testid="take-all")
        if marks.line is not None:
            length = _number(
                "Length of the line, mm", "line-mm", "of what the line lies over", LENGTHS
            )
            length.field.set_value(self._length_mm)
            length.field.on("change", lambda: self._measure_line(length))
        part, size = marks.part, self._look.size
        if size is not None:
            x, y, w, h = window_of(part or (0, 0, *size), size)
            whole = "All of the picture is" if part is None else "Only a part is"
            ui.label(f"{whole} looked at: columns {x} to {x + w}, rows {y} to {y + h}.").classes(
                "note"
            ).props("data-testid=part-words")

    def _rated(self) -> None:
        self._rate_hz = self._rate.value
        self.refresh()

    def _measure_line(self, length: OptionalNumber) -> None:
        if length.valid:
            self._length_mm = length.value
            self.refresh()
        else:
            # It stays in its field, with what is allowed; by the one before nothing is measured.
            self.ready = False


def _number(label: str, testid: str, hint: str, within: Range) -> OptionalNumber:
    placed = OptionalNumber(label, testid, within[:2], within[2])
    placed.field.classes("wide").tooltip(hint)
    return placed


class FilmView:
    """Three steps for some films; ball, part and rate hold for all of them."""

    def __init__(self, desk: Desk, brought: Brought) -> None:
        self._desk, self._brought = desk, brought
        self._measuring = 0
        self._stated: Json = {}
        self._marks = Marks()
        self._results = brought.results()
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
            unlike = unlike_words(self._marks, answer["ball"]["diameter_px"]["value"])
            answer["notes"] += [unlike] if unlike else []
        else:
            self._failures[number] = self._measure.failure
        if number + 1 < len(self._brought.films) and not self._measure.cancelled:
            self._measuring = number + 1
            self._measure.start()

    def _start(self) -> None:
        if not self._form.ready:
            return
        # What is stated now holds for all films, whatever is changed meanwhile.
        self._stated, self._marks = self._form.stated(), self._look.marks
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
            **self._stated,
            "figure": str(folder / f"{FIGURE}-{number + 1}.png"),
            "result": str(folder / f"{RESULT}-{number + 1}.json"),
            "earlier": [str(folder / f"{RESULT}-{done + 1}.json") for done in self._results],
            "campaign": str(folder / CAMPAIGN),
        }
        work = in_process(f"{FUNCTIONS}:measure_job", asked)
        return self._desk.daemon.jobs.submit("film", films[number].name, work)


KINDS = (
    "Films of a ball that bounces: MP4, MOV, AVI, MKV, NPY, Photron or Phantom; several at once.",
    "The pictures of one film, all PNG, TIFF or DNG together.",
    "A table of impacts as CSV: speeds before and after, or heights of fall and rebound.",
    "A campaign of any laboratory: its exchange folder as one ZIP.",
)


def own_pages(desk: Desk) -> None:
    """Register `/own`; `?brought=` names what was dropped before."""

    @kept_page(SHOWN_AT)
    def own(brought: str = "") -> None:
        with sheet(desk, "Your own data", "/campaigns"):
            ui.html("Bring your own collision", sanitize=False, tag="h2").classes("own-heading")
            ui.label(
                "A film of any ball, or the tables of any laboratory. It stays on this rig's "
                "computer: nothing goes anywhere else."
            ).classes("note")
            if not brought:
                _drop()
                _before(brought_before(desk.daemon.store.path))
                return
            try:
                found = known(desk.daemon.store.path, brought)
            except RigError as error:
                ui.label(error.sentence()).classes("verdict bad")
                _drop()
                return
            if found.films:
                FilmView(desk, found)
            elif found.table is not None:
                TableView(desk, found, found.table)
            else:
                _campaign(desk, found)


def _drop() -> None:
    with ui.element("section").classes("panel drop"):
        ui.html("Drop it here", sanitize=False, tag="h3").classes("card-heading")
        with ui.element("ul").classes("chain"):
            for kind in KINDS:
                ui.html(kind, sanitize=False, tag="li")
        drop_field()


def _before(found: Sequence[Brought]) -> None:
    """List what was brought before, each with its address."""
    if not found:
        return
    with ui.element("section").classes("panel").props("data-testid=brought-before"):
        ui.html("Brought before", sanitize=False, tag="h3").classes("card-heading")
        with ui.element("ul").classes("chain"):
            for one in found:
                with ui.element("li"):
                    ui.link(one.name, f"{SHOWN_AT}?brought={one.token}")
                    if measured := len(one.results()):
                        ui.label(f"{measured} measured").classes("note")


def _campaign(desk: Desk, found: Brought) -> None:
    with ui.element("section").classes("panel").props("data-testid=own-campaign"):
        source = Source.of_folder(desk.daemon, str(found.campaign))
        ui.label(f"Campaign {source.title}").classes("title")
        ui.label("Its tables are used as they are; a fault in them is named with its line.")
        button(
            "Compare with the model",
            lambda: ui.navigate.to(source.address),
            look="fill",
            testid="own-compare",
        )
        ui.link("bring something else", SHOWN_AT).classes("note")
