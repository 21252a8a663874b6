"""Frames of stored shots as pictures for the page, decoded once for all who look."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from fastapi import FastAPI
from numpy.typing import NDArray
from starlette.responses import Response

from rigctl.errors import RigError
from rigctl.page.desk import Desk
from rigctl.service.pictures import frame_of, png
from rigctl.service.problems import answer, from_error

KEPT_STACKS = 3
FOREVER = {"Cache-Control": "private, max-age=86400, immutable"}
"""Frames on disk never change."""


def frame_address(shot: str, frame: int) -> str:
    """Return where the page finds a frame, counted from 0."""
    return f"/film/{shot}/{frame}.png"


def film_route(app: FastAPI, desk: Desk) -> None:
    """Register the route of the frames, beside the pages: a browser often gives frames up."""

    @lru_cache(maxsize=KEPT_STACKS)
    def pixels(shot: str) -> NDArray[np.uint8]:
        return desk.daemon.store.frames(shot).pixels

    @app.get("/film/{shot}/{frame}.png", include_in_schema=False)
    def frame(shot: str, frame: int) -> Response:
        try:
            picture = frame_of(pixels(shot), frame, shot)
        except RigError as error:
            return answer(from_error(error))
        return Response(png(picture), media_type="image/png", headers=FOREVER)
