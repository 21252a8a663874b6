"""Frames of one shot of two spheres, grey, from any film that a reader opens."""

from __future__ import annotations

from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.films.film import Film
from analysis.balls.films.high_speed import HEADER_SUFFIXES
from analysis.balls.films.reading import FILM_SUFFIXES, VIDEO_SUFFIXES, open_film
from analysis.balls.films.stacks import RAW_SUFFIX
from analysis.balls.films.tone import BRIGHTNESS
from analysis.errors import InputError
from analysis.files import FrameBudget
from analysis.imaging.files.png_files import holds_png
from analysis.imaging.files.stack import (
    SUFFIXES,
    FrameStack,
    on_scale_of_8_bits,
    read_stack,
    recorded_times,
)
from analysis.imaging.files.video_file import ColourError

FRAME_SUFFIXES = tuple(suffix for suffix in FILM_SUFFIXES if suffix not in HEADER_SUFFIXES)
"""Of one shot's file; a header lies beside its frames."""
COLOUR = "frames are in colour: their brightness is measured"


def read_frames(path: Path) -> FrameStack:
    """Read the frames of one shot, grey, with all their bits.

    Plain grey frames are those of `read_stack`. Cameras' own files and raw pictures are read as
    films are; of colour the brightness (ITU-R BT.601) is taken. Times are those beside the frames,
    else those of a camera's own file, else by the rate that it states; its exposure comes along.

    Raises
    ------
    InputError
        As `read_stack` and `open_film`.
    """
    plain = not holds_raw(path) if path.is_dir() else path.suffix.lower() not in _only_films()
    if plain:
        try:
            return read_stack(path)
        except ColourError:
            pass
    return _grey(open_film(path))


def holds_raw(folder: Path) -> bool:
    """Return whether a folder could be a shot's frames as a sensor gave them."""
    return any(path.suffix.lower() == RAW_SUFFIX for path in folder.iterdir())


def holds_frames(folder: Path) -> bool:
    """Return whether a folder could be a shot's frames."""
    return holds_png(folder) or holds_raw(folder)


def _only_films() -> set[str]:
    return set(FILM_SUFFIXES) - set(SUFFIXES)


def _grey(film: Film) -> FrameStack:
    head, budget = film.head, FrameBudget(film.path)
    colour, pages, largest, deep = head.channels == 3, [], 0, False
    for picture in film.pictures():
        budget.claim((head.height, head.width), 4 if colour else picture.itemsize)
        pages.append(_brightness(picture) if colour else picture[..., 0])
        largest, deep = max(largest, int(picture.max())), deep or picture.dtype != np.uint8
    if len(pages) < head.frames:
        have = f"{len(pages)} of its {head.frames} frames can be read"
        raise InputError(film.path, f"{have}: the rest is missing or damaged")
    values: NDArray[np.generic] = np.stack(pages)
    times = _times(film, len(pages))
    notes = (*head.notes, COLOUR) if colour else head.notes
    if deep:
        light, note = on_scale_of_8_bits(values, largest)
        notes = (*notes, note)
    elif colour:
        light = cast("NDArray[np.float32]", values)
    else:
        whole = cast("NDArray[np.uint8]", values)
        return FrameStack(whole, whole, times, notes, head.exposure_s)
    return FrameStack(np.rint(light).astype(np.uint8), light, times, notes, head.exposure_s)


def _brightness(picture: NDArray[np.generic]) -> NDArray[np.float32]:
    return np.asarray(picture.astype(np.float32) @ BRIGHTNESS.astype(np.float32), np.float32)


def _times(film: Film, frames: int) -> Floats | None:
    """Return times beside the frames, else those a camera wrote, else times by its rate, s.

    Times and rate of a video are its player's and are not taken.
    """
    recorded = recorded_times(film.path, frames)
    if recorded is not None or film.path.suffix.lower() in VIDEO_SUFFIXES:
        return recorded
    head = film.head
    if head.times_s is None and head.rate_hz is not None:
        return np.asarray(np.arange(frames) / head.rate_hz)
    return head.times_s
