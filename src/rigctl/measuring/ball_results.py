"""From a film or a table of one ball to its result: the command, the page and Python share it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from analysis.balls.analysis import FilmJob, analyse_film
from analysis.balls.document import Json, ball_document
from analysis.balls.tracks.analysis import analyse_table
from analysis.balls.tracks.table import TABLE_SUFFIXES


@dataclass(frozen=True, slots=True)
class BallResult:
    """What was measured of one ball.

    Attributes
    ----------
    document
        As commands.md has it, with the number of the shot.
    frames
        How many there are; 0 of bounces that were heard.
    size
        Rows and columns of the picture in which its places are.
    draw
        Writes a picture of it to a path under a title; None: of bounces that were heard there is
        none.
    """

    document: Json
    frames: int
    size: tuple[int, int]
    draw: Callable[[Path, str], None] | None


def ball_result(job: FilmJob) -> BallResult:
    """Measure a film, or a table of places or of bounces.

    Raises
    ------
    InputError
        It cannot be read.
    ShotRefusedError
        Nothing in it is a ball in flight; with what `analyse_film` and `analyse_table` raise.
    """
    if is_table(job.path):
        return _of_table(job)
    film = analyse_film(job)
    head = film.film.head

    def draw(path: Path, title: str) -> None:
        from analysis.figures.ball_film import draw_ball_film  # noqa: PLC0415 - loads matplotlib

        draw_ball_film(path, title, film)

    document = {"shot": job.shot, **ball_document(film.measured, film.notes)}
    return BallResult(document, head.frames, (head.height, head.width), draw)


def _of_table(job: FilmJob) -> BallResult:
    table = analyse_table(job)
    track = table.track
    document = {"shot": job.shot, **table.document}
    if track is None:
        return BallResult(document, table.frames, table.size, None)

    def draw(path: Path, title: str) -> None:
        from analysis.figures.ball_track import draw_ball_track  # noqa: PLC0415 - loads matplotlib

        draw_ball_track(path, title, track, document)

    return BallResult(document, table.frames, table.size, draw)


def is_table(path: Path) -> bool:
    """Return whether a file is read as a table, by its name."""
    return path.suffix.lower() in TABLE_SUFFIXES
