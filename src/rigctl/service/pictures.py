"""Frames as PNG pictures, plain or with what the analysis found drawn over them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from rigctl.errors import FramesError, NotFoundError

# Okabe and Ito's sky blue and orange, in OpenCV's order: blue, green, red.
_COLOURS = {"a": (233, 180, 86), "b": (0, 159, 230)}
_ENLARGED = 3
_FRACTION_BITS = 4
_MARKER_RADIUS_PX = 1.0


class Marker(BaseModel):
    """A marker seen on a sphere; (row, column) in pixels, an integer is the centre of a pixel."""

    sphere: Literal["a", "b"]
    row: float
    column: float


class Outline(Marker):
    """A sphere's outline in one view; `radius` in pixels."""

    radius: float


class FrameOverlay(BaseModel):
    """What the analysis found in one frame."""

    frame: int
    outlines: list[Outline]
    markers: list[Marker]


class Drawable(BaseModel):
    """The part of a result that can be drawn; a result without it leaves frames plain."""

    overlay: list[FrameOverlay] = Field(default_factory=list)


def frame_of(pixels: NDArray[np.uint8], number: int, shot: str) -> NDArray[np.uint8]:
    """Return frame `number`, counted from 0, of a stack of shape (frames, rows, columns).

    Raises
    ------
    NotFoundError
        The shot has fewer frames.
    """
    if number >= len(pixels):
        raise NotFoundError(
            "the shot has no such frame",
            part="frame",
            value=str(number),
            limit=f"0 to {len(pixels) - 1}",
            todo="ask for a frame the shot has",
            shot=shot,
        )
    frame: NDArray[np.uint8] = pixels[number]
    return frame


def png(picture: NDArray[np.uint8]) -> bytes:
    """Return a grey (rows, columns) or blue-green-red (rows, columns, 3) picture as PNG."""
    done, data = cv2.imencode(".png", picture)
    if not done:
        raise FramesError("the frame cannot be written as PNG", value=str(picture.shape))
    return data.tobytes()


def overlaid(frame: NDArray[np.uint8], result: Mapping[str, Any], number: int) -> NDArray[np.uint8]:
    """Return frame `number` with the outlines and markers that a result holds for it.

    Without an entry for the frame it comes back as it is. Otherwise the picture is in colour, shape
    (3 rows, 3 columns, 3): sphere a sky blue, sphere b orange, markers as small rings.
    """
    found = [each for each in Drawable.model_validate(result).overlay if each.frame == number]
    if not found:
        return frame
    grey = frame.repeat(_ENLARGED, axis=0).repeat(_ENLARGED, axis=1)
    picture = np.stack([grey, grey, grey], axis=2)
    for overlay in found:
        for outline in overlay.outlines:
            _ring(picture, outline, outline.radius)
        for marker in overlay.markers:
            _ring(picture, marker, _MARKER_RADIUS_PX)
    return picture


def _ring(picture: NDArray[np.uint8], centre: Marker, radius: float) -> None:
    """Draw a circle given in pixels of the frame, to a sixteenth of a pixel."""
    scale = _ENLARGED * 2**_FRACTION_BITS
    # The centre of a pixel lies half a pixel from its corner, in the frame and enlarged alike.
    half = 2**_FRACTION_BITS / 2
    row = round((centre.row + 0.5) * scale - half)
    column = round((centre.column + 0.5) * scale - half)
    colour = _COLOURS[centre.sphere]
    cv2.circle(
        picture, (column, row), round(radius * scale), colour, 1, cv2.LINE_AA, _FRACTION_BITS
    )
