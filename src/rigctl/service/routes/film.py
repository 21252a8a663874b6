"""Films that people bring for a shot: what it waits for, their word, and the film itself."""

from __future__ import annotations

import asyncio
from typing import Annotated, Literal

import anyio
from fastapi import APIRouter, Path, Request
from pydantic import BaseModel, Field
from starlette.responses import Response

from rigctl.cameras.brought import BroughtFilm, Wish
from rigctl.config.model import StrictModel
from rigctl.daemon import Daemon
from rigctl.errors import AnalysisInputError, NotFoundError
from rigctl.measuring.brought_film import bring_film, new_film
from rigctl.service.accepted import accepted, accepts
from rigctl.service.guards.requests import StrictRoute
from rigctl.service.problems import documented

BROUGHT_WITHIN_S = 900.0
"""A film that has not come whole within this time is refused, s."""


class FilmWord(StrictModel):
    """What somebody says of the camera."""

    says: Literal["records", "gives-up"] = Field(
        description="records: the camera films now, fire; gives-up: end the wait, there is no film"
    )


class FilmView(BaseModel):
    """What the shot under way waits for, and what of the film is kept."""

    waits_for: Wish
    rows: int
    columns: int
    frames: int = Field(description="that are kept of a film, those with the motion")
    frame_rate_hz: float

    @classmethod
    def of(cls, film: BroughtFilm) -> FilmView:
        """Return how things stand."""
        section = film.settings
        return cls(
            waits_for=film.wish,
            rows=section.rows,
            columns=section.columns,
            frames=section.frames_before_mark + section.frames_after_mark,
            frame_rate_hz=section.frame_rate_hz,
        )


def film_routes(daemon: Daemon) -> APIRouter:
    """Return the routes below `/rig/film`."""
    router = APIRouter(prefix="/rig/film", tags=["rig"], route_class=StrictRoute)

    @router.get("", responses=documented(401, 404, 405))
    def status() -> FilmView:
        """Show what the shot under way waits for."""
        return FilmView.of(require_film(daemon))

    @router.post("", responses=documented(401, 404, 405, 409, 411, 413, 422))
    def say(word: FilmWord, request: Request) -> FilmView:
        """Take a person's word: the camera records, or there is no film."""
        film = require_film(daemon)
        if word.says == "records":
            film.records(request.state.actor)
        else:
            film.give_up()
        return FilmView.of(film)

    @router.put(
        "/{name}",
        status_code=202,
        response_model=None,
        responses=accepts() | documented(401, 404, 405, 408, 409, 411, 413, 422),
        openapi_extra={
            "requestBody": {
                "required": True,
                "content": {
                    "application/octet-stream": {"schema": {"type": "string", "format": "binary"}}
                },
            }
        },
    )
    async def bring(
        name: Annotated[str, Path(pattern="^[A-Za-z0-9_-][A-Za-z0-9_. -]{0,119}$")],
        request: Request,
    ) -> Response:
        """Bring the film as the body; a job reads it, and the shot goes on with its frames."""
        film = require_film(daemon)
        film.require("film")
        path = await asyncio.to_thread(new_film, daemon.store.path, name)
        try:
            with anyio.fail_after(BROUGHT_WITHIN_S):
                async with await anyio.open_file(path, "wb") as kept:
                    async for part in request.stream():
                        await kept.write(part)
        except TimeoutError as error:
            raise AnalysisInputError(
                "did not come in time", part=name, limit=f"{BROUGHT_WITHIN_S:g} s"
            ) from error
        return accepted(bring_film(daemon.jobs, film, path))

    return router


def require_film(daemon: Daemon) -> BroughtFilm:
    """Return what takes films; raise `NotFoundError` where the rig works its camera itself."""
    if daemon.film is None:
        raise NotFoundError(
            "this rig's camera brings its frames itself",
            part="camera",
            todo='films of a telephone are for kind = "film"; rigctl analyse takes any other',
        )
    return daemon.film
