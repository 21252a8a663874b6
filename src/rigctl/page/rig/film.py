"""A camera that people work, on the page: say that it records, and drop its film for the shot."""

from __future__ import annotations

import asyncio

from fastapi import FastAPI, Request
from nicegui import ui
from starlette.datastructures import UploadFile
from starlette.requests import ClientDisconnect
from starlette.responses import JSONResponse, Response

from rigctl.cameras.brought import BroughtFilm, Wish
from rigctl.errors import AnalysisInputError, RigError
from rigctl.jobs import ENDED, JobState
from rigctl.measuring.brought_film import bring_film, new_film
from rigctl.page.desk import Desk, actor
from rigctl.page.layout import sheet
from rigctl.page.own.brought import safe_name
from rigctl.page.own.dropping import awaited, drop_field, keep, require_room
from rigctl.page.parts.presence import every, kept_page
from rigctl.page.parts.waiting import Waiting
from rigctl.page.parts.widgets import button
from rigctl.service.routes.film import require_film

PLACE = "/film"
ADDRESS = "/shot-film"
LOOK_S = 0.5
WORDS: dict[Wish, str] = {
    "nothing": "No shot waits. Arm and fire on the rig's page; then come back here.",
    "recording": "A shot waits for the camera. Start its film, then say so: the rig fires at once.",
    "film": "The shot is fired. End the film, and drop it below.",
}


def film_page(desk: Desk) -> None:
    """Register the page at `/film`."""

    @kept_page(PLACE)
    def page(job: str = "") -> None:
        with sheet(desk, "Film", "/"):
            ui.html("Film of a telephone", sanitize=False, tag="h2").classes("own-heading")
            if desk.daemon.film is None:
                ui.label("This rig works its camera itself.").classes("empty")
                return
            FilmDesk(desk, desk.daemon.film, job)


class FilmDesk:
    """What the shot waits for, the two words, and the field; looked at twice a second."""

    def __init__(self, desk: Desk, film: BroughtFilm, job: str) -> None:
        self._desk, self._film, self._job = desk, film, job
        who = actor()
        with ui.element("div").classes("panel"):
            ui.label("Film of the shot").classes("title")
            self._waits = ui.label().props("data-testid=film-waits role=status")
            with ui.element("div").classes("beside"):
                self._records = button(
                    "The camera records: fire",
                    lambda: desk.done(lambda: film.records(who), moves=True),
                    look="main fill",
                    testid="film-records",
                )
                self._gives_up = button(
                    "There is no film", lambda: desk.done(film.give_up), testid="film-gives-up"
                )
            Waiting(desk, "Reading the film", self._runs, "film-reading")
            self._read = ui.label().classes("note").props("data-testid=film-read role=status")
        with ui.element("div").classes("panel") as field:
            drop_field(ADDRESS)
        self._field = field
        every(LOOK_S, self._look)
        self._look()

    def _look(self) -> None:
        wish = self._film.wish
        self._waits.set_text(WORDS[wish])
        self._records.set_enabled(wish == "recording")
        self._gives_up.set_enabled(wish != "nothing")
        self._field.set_visibility(wish == "film")
        if self._job:
            self._read.set_text(self._reading())

    def _runs(self) -> str:
        """Return the job that reads the film that was dropped last; empty once it has ended."""
        try:
            job = self._desk.daemon.jobs.job(self._job)
        except RigError:
            return ""
        return "" if job.state in ENDED else job.id

    def _reading(self) -> str:
        """Say what came of the film that was dropped last."""
        try:
            job = self._desk.daemon.jobs.job(self._job)
        except RigError:
            return ""
        if job.state not in ENDED:
            return ""
        if job.state is JobState.DONE:
            return f"{job.subject}: the shot has its frames."
        return f"{job.subject}: {job.failure or job.state}"


def shot_film_route(app: FastAPI, desk: Desk) -> None:
    """Register the route of dropped films, beside the pages."""

    @app.post(ADDRESS, include_in_schema=False)
    async def bring(request: Request) -> Response:
        try:
            film = require_film(desk.daemon)
            film.require("film")
            require_room(request)
            async with request.form(max_files=1) as form:
                file = form.get("files")
                if not isinstance(file, UploadFile):
                    raise AnalysisInputError("is no file", part="the film", todo="drop one file")
                name = safe_name(file.filename or "")
                path = await asyncio.to_thread(new_film, desk.daemon.store.path, name)
                async with awaited(request):
                    await keep(file, path)
            job = bring_film(desk.daemon.jobs, film, path)
        except ClientDisconnect:
            # Cancelled: the shot waits on, and the next film takes the place of this one.
            return Response(status_code=400)
        except RigError as error:
            return JSONResponse({"detail": error.sentence()}, 422)
        return JSONResponse({"address": f"{PLACE}?job={job.id}"})
