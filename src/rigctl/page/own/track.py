"""A tracker's places, or bounces that were heard, in three steps: look, state, measure."""

from __future__ import annotations

from pathlib import Path

from nicegui import ui

from rigctl.jobs import Job, in_process
from rigctl.page.desk import Desk
from rigctl.page.layout import TICK_S
from rigctl.page.model.state import Question
from rigctl.page.own.brought import Brought
from rigctl.page.own.dropping import SHOWN_AT
from rigctl.page.own.look import FUNCTIONS
from rigctl.page.own.measuring import MeasuringPanel
from rigctl.page.own.scale import DIAMETERS, MASSES, RATES, number
from rigctl.page.parts.following import following
from rigctl.page.parts.waiting import Waiting
from rigctl.page.parts.widgets import button

AS_IMPACTS = "impacts"
"""How the page's address asks for a table to be taken as one of impacts."""


class TrackView:
    """What the table holds, the ball and the rate, and what came of it.

    Attributes
    ----------
    ready
        Whether the ball's diameter is known, and a frame rate.
    """

    def __init__(self, desk: Desk, brought: Brought, path: Path) -> None:
        self._desk, self._path = desk, path
        self.ready = False
        self._look = Question(self._ask, desk.daemon.jobs.job)
        self._look.start()
        with ui.element("div").classes("columns own"):
            with ui.element("section").classes("panel"):
                ui.html("1 What it holds", sanitize=False, tag="h3").classes("card-heading")
                Waiting(desk, "Reading the table", lambda: self._look.running or "", "looking")
                self._head()
                ui.link(
                    "It is a table of impacts: say what its columns are",
                    f"{SHOWN_AT}?brought={brought.token}&table={AS_IMPACTS}",
                ).classes("note").props("data-testid=as-impacts")
            with ui.element("section").classes("panel"):
                self._form()
        self._panel = MeasuringPanel(desk, brought, (path,), "3 Measured")
        following(TICK_S * 2, self._follow)

    def _form(self) -> None:
        ui.html("2 The ball", sanitize=False, tag="h3").classes("card-heading")
        self._diameter = number(
            "Diameter of the ball, mm", "ball-diameter-mm", "its drag follows", DIAMETERS
        )
        self._mass = number(
            "Its mass, g (if known)", "ball-mass-g", "then the air's drag is known", MASSES
        )
        self._rate = number("Frames a second, if not the table's", "fps", "of the camera", RATES)
        self._scale = ui.label(
            "The scale is that of the fall; a length that the tracker was told is compared with it."
        ).classes("note")
        for each in (self._diameter, self._mass, self._rate):
            each.field.on_value_change(self._stated_now)
        go = button("Measure", self._start, look="main fill", testid="own-measure")
        go.bind_enabled_from(self, "ready")
        ui.link("bring something else", SHOWN_AT).classes("note")

    @ui.refreshable_method
    def _head(self) -> None:
        answer = self._look.answer
        if self._look.failure:
            ui.label(self._look.failure).classes("verdict bad").props(
                "data-testid=own-failed role=alert"
            )
        if answer is None:
            ui.label(f"{self._path.name} …").classes("empty")
            return
        ui.label(f"{self._path.name}: {answer['said']}.").props("data-testid=own-track")
        if not answer["timed"] and self._rate.value is None:
            ui.label("State the frames a second of the camera.").classes("note").props(
                "data-testid=no-rate role=status"
            )

    def _stated_now(self) -> None:
        answer = self._look.answer
        fields = (self._diameter, self._mass, self._rate)
        timed = answer is not None and (answer["timed"] or self._rate.value is not None)
        known = self._diameter.value is not None
        # Bounces that were heard have no camera, and no lengths.
        seen = answer is None or not answer["heard"]
        self._rate.field.set_visibility(seen)
        self._scale.set_visibility(seen)
        self.ready = timed and known and all(field.valid for field in fields)
        self._head.refresh()

    def _follow(self) -> None:
        if self._look.follow():
            self._stated_now()
        self._panel.follow()

    def _start(self) -> None:
        if self.ready:
            self._panel.start(
                {
                    "diameter_mm": self._diameter.value,
                    "diameter_sigma": 0.0,
                    "mass_g": self._mass.value,
                    "rate_hz": self._rate.value,
                    "window": None,
                }
            )

    def _ask(self) -> Job:
        work = in_process(f"{FUNCTIONS}:table_job", {"path": str(self._path)})
        return self._desk.daemon.jobs.submit("look", self._path.name, work)
