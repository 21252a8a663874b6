"""Frames of stored shots as pictures for the page, decoded once for all who look."""

from __future__ import annotations

from functools import lru_cache

from fastapi import FastAPI
from starlette.responses import Response

from rigctl.errors import RigError
from rigctl.page.desk import Desk
from rigctl.page.parts.shared_reading import read_once
from rigctl.service.pictures import frame_of, png
from rigctl.service.problems import answer, from_error

KEPT_STACKS, KEPT_PICTURES = 3, 300
FOREVER = {"Cache-Control": "private, max-age=86400, immutable"}
"""Frames on disk never change."""


def frame_address(shot: str, frame: int) -> str:
    """Return where the page finds a frame, counted from 0."""
    return f"/film/{shot}/{frame}.png"


def film_route(app: FastAPI, desk: Desk) -> None:
    """Register the route of the frames, beside the pages: a browser often gives frames up."""
    pixels = read_once(lambda shot: desk.daemon.store.frames(shot).pixels, KEPT_STACKS)

    @lru_cache(maxsize=KEPT_PICTURES)
    def picture(shot: str, frame: int) -> bytes:
        return png(frame_of(pixels(shot), frame, shot))

    @app.get("/film/{shot}/{frame}.png", include_in_schema=False)
    def frame(shot: str, frame: int) -> Response:
        try:
            drawn = picture(shot, frame)
        except RigError as error:
            return answer(from_error(error))
        return Response(drawn, media_type="image/png", headers=FOREVER)
