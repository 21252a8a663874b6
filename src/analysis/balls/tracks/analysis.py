"""A table of places or of bounces from file to result: what `rigctl analyse` does with one."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from analysis.balls.analysis import FilmJob
from analysis.balls.document import Json
from analysis.balls.tracks.bounce_times import (
    bounce_document,
    read_bounce_times,
)
from analysis.balls.tracks.document import track_document
from analysis.balls.tracks.measuring import MeasuredTrack, measure_track
from analysis.balls.tracks.table import TrackTable, is_table_of_bounces, read_track_table
from analysis.errors import ShotRefusedError

PICTURE = 480, 640
"""Rows and columns that a campaign without any picture has."""
NO_CAMERA = (
    "a frame rate or an exposure is stated, and does not count: bounces that were heard have times "
    "of their own"
)


@dataclass(frozen=True, slots=True)
class AnalysedTable:
    """What a table says of a ball.

    Attributes
    ----------
    document
        As `ball_document` has it, without what pictures alone show.
    frames
        How many there are; 0 of bounces that were heard.
    size
        Rows and columns of the picture in which its poses are.
    track
        The ball's flights; None of bounces that were heard.
    """

    document: Json
    frames: int
    size: tuple[int, int]
    track: MeasuredTrack | None = None


def analyse_table(job: FilmJob) -> AnalysedTable:
    """Measure the bounces in one table.

    Raises
    ------
    InputError
        It cannot be read.
    ShotRefusedError
        It has no times, nothing in it falls and bounces, or something is asked of its pictures.
    """
    cut = job.cut
    if job.lens is not None or (cut is not None and cut.window is not None):
        raise ShotRefusedError(
            "frames", "a table has no pictures; leave out --lens and --roi, or state its film"
        )
    if is_table_of_bounces(job.path):
        if cut is not None:
            raise ShotRefusedError("frames", "bounces that were heard have no frames for --frames")
        document = bounce_document(read_bounce_times(job.path), job.ball)
        if job.rate_hz is not None or job.exposure_s is not None:
            document["notes"].append(NO_CAMERA)
        return AnalysedTable(document, 0, PICTURE)
    table = read_track_table(job.path)
    if cut is not None:
        table = _part(table, cut.first, cut.last)
    measured = measure_track(table, job.ball, job.rate_hz, job.exposure_s)
    frames, size = len(measured.times_s), measured.size
    return AnalysedTable(track_document(measured), frames, size, measured)


def _part(table: TrackTable, first: int, last: int | None) -> TrackTable:
    """Return the places of some frames, numbered as before."""
    own = (table.frames >= first) & (table.frames < (np.inf if last is None else last))
    if not own.any():
        raise ShotRefusedError(
            "frames",
            f"none of the table's frames, {table.frames.min():g} to {table.frames.max():g}, are "
            "those that were asked for with --frames",
        )
    return replace(
        table,
        frames=table.frames[own],
        times_s=None if table.times_s is None else table.times_s[own],
        places=table.places[own],
        things=table.things[own],
    )
