"""Frames of stored shots as pictures for the page, decoded once for all who look."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Annotated

import numpy as np
from fastapi import FastAPI, Path
from starlette.responses import Response

from rigctl.errors import RigError
from rigctl.page.desk import Desk
from rigctl.page.parts.shared_reading import read_once
from rigctl.service.pictures import frame_of, png
from rigctl.service.problems import answer, from_error

KEPT_STACKS, KEPT_PICTURES, KEPT_STRIPS = 3, 300, 30
FRAMES = r"^\d{1,7}(-\d{1,7}){0,9}$"
"""Numbers of at most ten frames."""
FOREVER = {"Cache-Control": "private, max-age=86400, immutable"}
"""Frames on disk never change."""


def frame_address(shot: str, frame: int) -> str:
    """Return where the page finds a frame, counted from 0."""
    return f"/film/{shot}/{frame}.png"


def strip_address(shot: str, frames: Sequence[int]) -> str:
    """Return where the page finds frames beside one another in one picture."""
    return f"/film/{shot}/strip/{'-'.join(map(str, frames))}.png"


def film_route(app: FastAPI, desk: Desk) -> None:
    """Register the route of the frames, beside the pages: a browser often gives frames up."""
    pixels = read_once(lambda shot: desk.daemon.store.frames(shot).pixels, KEPT_STACKS)

    @lru_cache(maxsize=KEPT_PICTURES)
    def picture(shot: str, frame: int) -> bytes:
        return png(frame_of(pixels(shot), frame, shot))

    @lru_cache(maxsize=KEPT_STRIPS)
    def side_by_side(shot: str, frames: str) -> bytes:
        stack = pixels(shot)
        return png(np.hstack([frame_of(stack, int(each), shot) for each in frames.split("-")]))

    @app.get("/film/{shot}/{frame}.png", include_in_schema=False)
    def frame(shot: str, frame: int) -> Response:
        return _drawn(lambda: picture(shot, frame))

    @app.get("/film/{shot}/strip/{frames}.png", include_in_schema=False)
    def strip(shot: str, frames: Annotated[str, Path(pattern=FRAMES)]) -> Response:
        return _drawn(lambda: side_by_side(shot, frames))


def _drawn(draw: Callable[[], bytes]) -> Response:
    try:
        return Response(draw(), media_type="image/png", headers=FOREVER)
    except RigError as error:
        return answer(from_error(error))
