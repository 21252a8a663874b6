"""From a file that somebody brings for a shot to the frames of it.

`frames_job` is called in a process of its own: a file of any kind may be broken.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analysis.balls.films.film import Film, FilmHead, Picture
from analysis.balls.films.part import Cut, PartOfFilm
from analysis.balls.films.reading import open_film
from analysis.errors import InputError
from rigctl.cameras.brought import BroughtFilm
from rigctl.cameras.frames import FrameSequence
from rigctl.config import FilmCamera
from rigctl.config.model import StrictModel
from rigctl.documents import Json
from rigctl.errors import AnalysisInputError
from rigctl.jobs import Job, Jobs, Task, in_process
from rigctl.progress import Progress

FOLDER = "film"
"""Folder of the film that was brought last, inside the store's."""
FRAMES = "shot-frames.npy"
CHANGED_SIGMAS = 6.0
LARGEST_SHARE = 0.3
"""Of the pixels: where more of them change, the camera itself was moved."""
RATE_TOLERANCE = 0.02
"""By which the file's rate may differ from the stated one for its times to be believed."""


class FrameNote(StrictModel):
    """Numbers and times of the frames that were taken from a film.

    Attributes
    ----------
    sequence
        Number of each, counted from the film's first frame with those that it left out.
    times_s
        From the film's first frame.
    lost
        Numbers that the film left out between them.
    note
        Where the times are from, for the manifest.
    """

    sequence: list[int]
    times_s: list[float]
    lost: list[int]
    note: str


def new_film(store: Path, name: str) -> Path:
    """Return where a film of this name is kept; the one before it is removed."""
    place = store / FOLDER
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    return place / name


def bring_film(jobs: Jobs, capture: BroughtFilm, path: Path) -> Job:
    """Read a film in the background and hand its frames to the shot that waits for them.

    Parameters
    ----------
    jobs
        Where it is read.
    capture
        Whose shot it is.
    path
        The film, in a folder of its own that may be written to.

    Raises
    ------
    RefusedError
        No shot waits for a film.
    """
    capture.require("film")
    section = capture.settings
    asked = {"path": str(path), "camera": section.model_dump_json()}
    reading = in_process("rigctl.measuring.brought_film:frames_job", asked)

    def work(task: Task) -> str:
        told = reading(task)
        capture.bring(_sequence(path.parent / FRAMES, told, path.name))
        return told

    return jobs.submit("film of a shot", path.name, work)


def _sequence(frames: Path, told: str, name: str) -> FrameSequence:
    document = FrameNote.model_validate_json(told)
    pixels = np.load(frames, allow_pickle=False)
    frames.unlink()
    return FrameSequence(
        pixels,
        np.array(document.times_s),
        np.array(document.sequence, dtype=np.int64),
        tuple(document.lost),
        f"{name}; {document.note}",
    )


def frames_job(asked: Json, progress: Progress) -> Json:
    """Write the part of a film that shows the shot as NPY beside it.

    `path` is the film, `camera` the camera's section as JSON.

    Raises
    ------
    AnalysisInputError
        It cannot be read, is smaller or shorter than configured, or nothing moves in it.
    """
    section = FilmCamera.model_validate_json(asked["camera"])
    path = Path(asked["path"])
    progress("opening the film", None)
    try:
        whole = open_film(path)
        film = _part(whole, section)
        progress("looking for what moves", 0.1)
        first = _first(film, section)
        progress("taking its frames", 0.7)
        last = first + section.frames_before_mark + section.frames_after_mark
        chosen = film.chosen(range(first, last))
    except InputError as error:
        raise AnalysisInputError(error.reason, part=Path(error.path).name) from error
    np.save(path.parent / FRAMES, np.stack([grey(chosen[k]) for k in range(first, last)]))
    return _note(whole.head, first, last, section.frame_rate_hz).model_dump()


def _part(film: Film, section: FilmCamera) -> Film:
    """Return the configured part of a film's pictures."""
    head = film.head
    top, left = section.corner
    if top + section.rows > head.height or left + section.columns > head.width:
        raise AnalysisInputError(
            "has smaller pictures than are configured",
            part=film.path.name,
            value=f"{head.height} x {head.width} (rows x columns)",
            limit=f"{section.rows} x {section.columns} from row {top}, column {left}",
            todo="correct rows, columns and corner under [camera], or the telephone's format",
        )
    return PartOfFilm(film, Cut(window=(left, top, section.columns, section.rows)))


def _first(film: Film, section: FilmCamera) -> int:
    """Return the first frame of the stretch in which most moves."""
    count = section.frames_before_mark + section.frames_after_mark
    if film.head.frames < count:
        raise AnalysisInputError(
            "is too short",
            part=film.path.name,
            value=f"{film.head.frames} frames",
            limit=f"at least {count}: frames_before_mark and frames_after_mark together",
            todo="film longer, or ask for fewer frames",
        )
    moving = motion(film.pictures())
    if not moving.any():
        raise AnalysisInputError(
            "shows nothing that moves",
            part=film.path.name,
            todo="see that it is this shot's film, and that corner, rows and columns hold the shot",
        )
    begun = int(np.flatnonzero(moving)[0])
    sums = np.convolve(moving, np.ones(count), mode="valid")
    best = np.flatnonzero(sums >= sums.max() * (1 - 1e-12))
    # Where all the motion fits, it begins after the frames that are kept from before the fire.
    wanted = max(0, begun - section.frames_before_mark)
    return int(best[np.abs(best - wanted).argmin()])


def motion(pictures: Iterable[Picture]) -> NDArray[np.float64]:
    """Return the share of pixels that change into each frame, shape (frames,); the first has 0.

    Changes of more than 30 % of them are no motion in the picture but one of the camera: 0 too.
    """
    shares = [0.0]
    before: NDArray[np.float32] | None = None
    for picture in pictures:
        now = grey(picture).astype(np.float32)
        if before is not None:
            changes = np.abs(now - before)
            noise = max(1.0, float(np.median(changes)) / 0.6745)
            share = float((changes > CHANGED_SIGMAS * noise).mean())
            shares.append(share if share <= LARGEST_SHARE else 0.0)
        before = now
    return np.array(shares)


def grey(picture: Picture) -> NDArray[np.uint8]:
    """Return a picture in 8-bit grey, of its green where it has colours: codecs keep that best."""
    green = picture[:, :, picture.shape[2] // 2]
    return np.asarray(green if green.dtype == np.uint8 else green >> 8, dtype=np.uint8)


def _note(head: FilmHead, first: int, last: int, rate_hz: float) -> FrameNote:
    """Return numbers and times: the file's own where its rate is the stated one."""
    chosen = np.arange(first, last)
    times = head.times_s
    if times is None or len(times) <= last - 1:
        note = "times by the stated rate: the file has none"
        return FrameNote(
            sequence=chosen.tolist(), times_s=(chosen / rate_hz).tolist(), lost=[], note=note
        )
    own = 1 / float(np.median(np.diff(times)))
    if abs(own / rate_hz - 1) > RATE_TOLERANCE:
        note = f"times by the stated {rate_hz:g} frames/s: the file is played at {own:.6g}"
        return FrameNote(
            sequence=chosen.tolist(), times_s=(chosen / rate_hz).tolist(), lost=[], note=note
        )
    numbers = np.rint((times - times[0]) * own).astype(np.int64)
    if not (np.diff(numbers) > 0).all():
        numbers = np.arange(len(times))
    sequence = numbers[first:last].tolist()
    lost = sorted(set(range(sequence[0], sequence[-1])) - set(sequence))
    taken = (times[first:last] - times[0]).tolist()
    return FrameNote(sequence=sequence, times_s=taken, lost=lost, note="times by the file")
