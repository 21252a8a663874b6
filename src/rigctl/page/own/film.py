"""A film that was brought: looked at, the ball stated, the part dragged, measured, handed back."""

from __future__ import annotations

from typing import Any

from nicegui import events, ui

from analysis.quantity import Quantity
from rigctl.jobs import Job, in_process
from rigctl.page.desk import Desk
from rigctl.page.layout import TICK_S
from rigctl.page.model.source import Source
from rigctl.page.model.state import Question
from rigctl.page.own.brought import CAMPAIGN, FIGURE, RESULT, Brought
from rigctl.page.own.downloads import ADDRESS
from rigctl.page.parts.following import following
from rigctl.page.parts.tables import Line, facts
from rigctl.page.parts.waiting import Waiting
from rigctl.page.parts.widgets import button

Json = dict[str, Any]
FUNCTIONS = "rigctl.measuring.own_film"
LEAST_PX = 8
"""A part of the picture that is smaller was a click and no drag."""
FEWEST_BOUNCES = 5
"""So many bounces are compared with the model; of fewer it says nothing."""


class FilmView:
    """Four steps for one film; each is drawn when the one before is answered."""

    def __init__(self, desk: Desk, brought: Brought) -> None:
        self._desk, self._brought = desk, brought
        self._window: list[int] | None = None
        self._from: tuple[float, float] | None = None
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
            self._measured.refresh()

    @property
    def _name(self) -> str:
        film = self._brought.film
        return "film" if film is None else film.name

    @ui.refreshable_method
    def _looked(self) -> None:
        ui.html("1 Is this what you filmed?", sanitize=False, tag="h3").classes("card-heading")
        answer = self._look.answer
        if self._look.failure:
            ui.label(self._look.failure).classes("verdict bad").props("data-testid=own-failed")
        if answer is None:
            ui.label(f"{self._name} …").classes("empty")
            return
        rate = answer["rate_hz"]
        rated = f"{rate:g} frames a second by the file" if rate else "the file says no frame rate"
        ui.label(
            f"{self._name}: {answer['frames']} frames of {answer['columns']} × {answer['rows']} "
            f"pixels; {rated}."
        ).props("data-testid=own-film")
        with ui.element("div").classes("strip"):
            for one in answer["pictures"]:
                self._thumbnail(one)
        named = ui.element("div").props('role=img aria-label="a frame of the film"')
        with named.classes("wide"):
            self._draggable(answer)
        ui.label("Drag over the picture to look at a part of it alone; a click takes it all.")

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
        ui.label("All speeds hang on the frame rate; the fall of the ball checks it.").classes(
            "note"
        )
        go = button("Measure", self._start, look="main fill", testid="own-measure")
        go.bind_enabled_from(self._diameter, "value", lambda value: bool(value and value > 0))
        ui.link("bring something else", "/own").classes("note")

    def _start(self) -> None:
        self._measure.start()
        self._measured.refresh()

    @ui.refreshable_method
    def _measured(self) -> None:
        ui.html("3 Measured", sanitize=False, tag="h3").classes("card-heading")
        answer = self._measure.answer
        if self._measure.failure:
            ui.label(self._measure.failure).classes("verdict bad").props("data-testid=own-failed")
        if answer is None:
            ui.label("Bounces, their speeds and e come here, with their errors.").classes("empty")
            return
        facts(["bounce", "at", "before, m/s", "after, m/s", "e"], _lines(answer), "own-bounces")
        for note in answer["notes"]:
            ui.label(note).classes("note")
        token = self._brought.token
        ui.html(
            f'<img src="{ADDRESS}/{token}/{FIGURE}" alt="The film with the ball\'s places, flights '
            'and bounces drawn over it, and what is left beside the flights.">',
            sanitize=False,
        ).classes("own-figure")
        with ui.element("div").classes("beside"):
            for name, said in (
                (FIGURE, "picture"),
                (RESULT, "all numbers as JSON"),
                (f"{CAMPAIGN}.zip", "campaign's folder as ZIP"),
            ):
                ui.link(f"Save the {said}", f"{ADDRESS}/{token}/{name}").props(f'download="{name}"')
            self._onwards(len(answer["impacts"]))

    def _onwards(self, bounces: int) -> None:
        """Offer the model, where there are bounces enough to say anything."""
        if bounces < FEWEST_BOUNCES:
            ui.label(
                f"{bounces} bounces are too few for the model; {FEWEST_BOUNCES} and more at "
                "several speeds tell whether e depends on speed."
            ).classes("note")
            return
        folder = str(self._brought.folder / CAMPAIGN)
        button(
            "Compare with the model",
            lambda: ui.navigate.to(Source.of_folder(self._desk.daemon, folder).address),
            look="fill",
            testid="own-compare",
        )

    def _ask_look(self) -> Job:
        asked = {"path": str(self._brought.film)}
        work = in_process(f"{FUNCTIONS}:look_job", asked)
        return self._desk.daemon.jobs.submit("look", self._name, work)

    def _ask_measure(self) -> Job:
        folder = self._brought.folder
        asked = {
            "path": str(self._brought.film),
            "name": self._name,
            "diameter_mm": self._diameter.value,
            "mass_g": self._mass.value or None,
            "rate_hz": self._rate.value or None,
            "window": self._window,
            "figure": str(folder / FIGURE),
            "result": str(folder / RESULT),
            "campaign": str(folder / CAMPAIGN),
        }
        return self._desk.daemon.jobs.submit(
            "film", self._name, in_process(f"{FUNCTIONS}:measure_job", asked)
        )


def _shown(picture: Json) -> str:
    return f"data:image/jpeg;base64,{picture['jpeg']}"


def _number(label: str, testid: str, hint: str) -> ui.number:
    placed = ui.number(label, min=0.0).props(f"outlined dense data-testid={testid}")
    return placed.classes("wide").tooltip(hint)


def _lines(answer: Json) -> list[Line]:
    lines = []
    for number, each in enumerate(answer["impacts"], start=1):
        when = Quantity(each["contact_time_s"], each["contact_time_sigma_s"], "s").concise()
        numbers = [
            Quantity(each[key]["value"], each[key]["sigma"], each[key]["unit"]).concise()
            for key in ("v_n", "v_n_after", "e")
        ]
        lines.append(Line([str(number), f"{when} s", *numbers]))
    return lines
