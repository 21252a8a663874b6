"""Films that were brought: looked at, the ball stated, the part dragged, measured, handed back."""

from __future__ import annotations

import shutil

from nicegui import events, ui

from rigctl.documents import Json
from rigctl.jobs import Job, in_process
from rigctl.page.desk import Desk
from rigctl.page.layout import TICK_S
from rigctl.page.model.state import Question
from rigctl.page.own.brought import CAMPAIGN, FIGURE, MEASURED, RESULT, Brought
from rigctl.page.own.measured import MeasuredFilms
from rigctl.page.parts.following import following
from rigctl.page.parts.waiting import Waiting
from rigctl.page.parts.widgets import button

FUNCTIONS = "rigctl.measuring.own_film"
LEAST_PX = 8
"""A part of the picture that is smaller was a click and no drag."""


class FilmView:
    """Three steps for some films; ball, part and rate hold for all of them."""

    def __init__(self, desk: Desk, brought: Brought) -> None:
        self._desk, self._brought = desk, brought
        self._window: list[int] | None = None
        self._from: tuple[float, float] | None = None
        self._seen, self._measuring = 0, 0
        self._results: dict[int, Json] = {}
        self._failures: dict[int, str] = {}
        jobs = desk.daemon.jobs
        self._look = Question(self._ask_look, jobs.job)
        self._measure = Question(self._ask_measure, jobs.job)
        self._look.start()
        with ui.element("div").classes("columns own"):
            with ui.element("section").classes("panel"):
                self._looked()
                Waiting(desk, "Looking at the film", lambda: self._look.running or "", "looking")
            with ui.element("section").classes("panel"):
                self._form()
        with ui.element("section").classes("panel").props("data-testid=own-result"):
            Waiting(desk, "Measuring", lambda: self._measure.running or "", "measuring")
            self._measured()
        following(TICK_S * 2, self._follow)

    def _follow(self) -> None:
        if self._look.follow():
            self._looked.refresh()
        if self._measure.follow():
            self._keep()
            self._measured.refresh()

    def _keep(self) -> None:
        """Keep what came of a film, and go on with the next one."""
        number = self._measuring
        if self._measure.answer is not None:
            self._results[number] = self._measure.answer
        else:
            self._failures[number] = self._measure.failure
        if number + 1 < len(self._brought.films):
            self._measuring = number + 1
            self._measure.start()

    def _name(self, number: int) -> str:
        return self._brought.films[number].name

    @ui.refreshable_method
    def _looked(self) -> None:
        ui.html("1 Is this what you filmed?", sanitize=False, tag="h3").classes("card-heading")
        if len(self._brought.films) > 1:
            with ui.element("div").classes("beside"):
                for number in range(len(self._brought.films)):
                    choice = button(
                        self._name(number), lambda number=number: self._see(number), look="line tab"
                    )
                    choice.props(f"aria-pressed={str(number == self._seen).lower()}")
        answer = self._look.answer
        if self._look.failure:
            ui.label(self._look.failure).classes("verdict bad").props("data-testid=own-failed")
        if answer is None:
            ui.label(f"{self._name(self._seen)} …").classes("empty")
            return
        rate = answer["rate_hz"]
        rated = f"{rate:g} frames a second by the file" if rate else "the file states no frame rate"
        ui.label(
            f"{self._name(self._seen)}: {answer['frames']} frames of {answer['columns']} × "
            f"{answer['rows']} pixels; {rated}."
        ).props("data-testid=own-film")
        with ui.element("div").classes("strip"):
            for one in answer["pictures"]:
                self._thumbnail(one)
        named = ui.element("div").props('role=img aria-label="a frame of the film"')
        with named.classes("wide"):
            self._draggable(answer)
        ui.label("Drag over the picture to look at a part of it alone; a click takes it all.")

    def _see(self, number: int) -> None:
        self._seen = number
        self._look.start()
        self._looked.refresh()

    def _draggable(self, answer: Json) -> None:
        self._picture = ui.interactive_image(
            _shown(answer["pictures"][len(answer["pictures"]) // 2]),
            size=(answer["columns"], answer["rows"]),
            events=["mousedown", "mouseup", "mousemove"],
            on_mouse=self._drag,
            sanitize=False,
        ).classes("dragged")
        self._picture.props("data-testid=own-picture aria-hidden=true")

    def _thumbnail(self, one: Json) -> None:
        with ui.element("button").classes("frame") as thumbnail:
            ui.element("img").props(f'src="{_shown(one)}" alt=""')
            ui.label(f"frame {one['frame']}")
        thumbnail.props(f'aria-label="show frame {one["frame"]}"')
        thumbnail.on("click", lambda: self._picture.set_source(_shown(one)))

    def _drag(self, event: events.MouseEventArguments) -> None:
        if event.type == "mousedown":
            self._from = event.image_x, event.image_y
        if self._from is None:
            return
        (x0, x1), (y0, y1) = (
            sorted(ends) for ends in zip(self._from, (event.image_x, event.image_y), strict=True)
        )
        if event.type == "mouseup":
            self._from = None
        whole = min(x1 - x0, y1 - y0) < LEAST_PX
        self._window = None if whole else [round(v) for v in (x0, y0, x1 - x0, y1 - y0)]
        frame = (
            ""
            if whole
            else (
                f'<rect x="{x0:.0f}" y="{y0:.0f}" width="{x1 - x0:.0f}" height="{y1 - y0:.0f}" '
                'fill="none" stroke="#E69F00" stroke-width="3"/>'
            )
        )
        self._picture.set_content(frame)

    def _form(self) -> None:
        ui.html("2 Scale", sanitize=False, tag="h3").classes("card-heading")
        self._diameter = _number("Diameter of the ball, mm", "ball-diameter-mm", "the scale")
        self._mass = _number(
            "Its mass, g (if known)", "ball-mass-g", "then the air's drag is known"
        )
        self._rate = _number("Frames a second, if not the file's", "fps", "of the camera")
        ui.label("All speeds follow from the frame rate; the fall of the ball checks it.").classes(
            "note"
        )
        count = len(self._brought.films)
        words = "Measure" if count == 1 else f"Measure {count} films"
        go = button(words, self._start, look="main fill", testid="own-measure")
        go.bind_enabled_from(self._diameter, "value", lambda value: bool(value and value > 0))
        ui.link("bring something else", "/own").classes("note")

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

    def _ask_look(self) -> Job:
        asked = {"path": str(self._brought.films[self._seen])}
        work = in_process(f"{FUNCTIONS}:look_job", asked)
        return self._desk.daemon.jobs.submit("look", self._name(self._seen), work)

    def _ask_measure(self) -> Job:
        folder, number = self._brought.folder / MEASURED, self._measuring
        name = self._name(number)
        asked = {
            "path": str(self._brought.films[number]),
            "shot": number + 1,
            "name": name,
            "title": self._name(0),
            "diameter_mm": self._diameter.value,
            "mass_g": self._mass.value or None,
            "rate_hz": self._rate.value or None,
            "window": self._window,
            "figure": str(folder / f"{FIGURE}-{number + 1}.png"),
            "result": str(folder / f"{RESULT}-{number + 1}.json"),
            "earlier": [str(folder / f"{RESULT}-{done + 1}.json") for done in self._results],
            "campaign": str(folder / CAMPAIGN),
        }
        work = in_process(f"{FUNCTIONS}:measure_job", asked)
        return self._desk.daemon.jobs.submit("film", name, work)


def _shown(picture: Json) -> str:
    return f"data:image/jpeg;base64,{picture['jpeg']}"


def _number(label: str, testid: str, hint: str) -> ui.number:
    placed = ui.number(label, min=0.0).props(f"outlined dense data-testid={testid}")
    return placed.classes("wide").tooltip(hint)
