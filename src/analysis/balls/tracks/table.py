"""Tables of trackers: places by frame or time, whatever the program calls its columns.

Read are tables with a line of names: of Tracker (Open Source Physics), of ImageJ's Manual Tracking,
MTrack2 and TrackMate (as CSV), of trackpy, of DLTdv, and any with columns frame or t, x and y.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.errors import InputError, counted

TABLE_SUFFIXES = (".csv", ".tsv", ".txt", ".dat")
MOST_BYTES = 50_000_000
TIMES = ("t", "time", "times", "positiont", "seconds")
FRAMES = ("frame", "frames", "framenumber", "frameno", "slice", "slicen", "image", "step")
THINGS = ("particle", "particleid", "trackid", "trackn", "track", "trajectory", "trajid")
"""Names of columns, those that a program writes beside another last."""
PLACE = re.compile(r"(?:pt\d+(?:cam\d+)?|position)?([xyz])\d*")
"""Names of places without units and punctuation: x, POSITION_X, X1, pt1_cam1_X."""
UNIT = re.compile(r"[\[(]\s*([a-zµ]*)\s*[\])]|[_ /](px|mm|cm|m|ms|s)$", re.IGNORECASE)
METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "micron": 1e-6, "in": 0.0254}
SECONDS = {"s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6}
BOUNCE = re.compile(r"bounce ?(\d+)(?: ?\((m?s)\))?", re.IGNORECASE)
"""Names of times at which a ball was heard, as phyphox writes them."""
NONE = {"", "nan", "na", "null", "none", "-"}
"""Cells of a frame in which nothing was found."""


@dataclass(frozen=True, slots=True, eq=False)
class TrackTable:
    """Places of everything that a tracker followed.

    Attributes
    ----------
    frames
        Of each place, shape (N,); of a table without such a column the number of its row.
    times_s
        Shape (N,); None: the table has no such column.
    places
        Along the table's axes x, y and, where it has one, z, in the table's unit; (N, 2 or 3).
    things
        What each place is of: the table's particle, or the column's track; shape (N,).
    metres
        What one unit of places is in m; None: the table does not say.
    numbered
        Whether the table has a column of frames.
    notes
        What of the table was not taken.
    """

    frames: Floats
    times_s: Floats | None
    places: Floats
    things: NDArray[np.str_]
    metres: float | None
    numbered: bool
    notes: tuple[str, ...]

    @property
    def states_times(self) -> bool:
        """Whether it has times; whole numbers, one after another, are numbers of frames."""
        if self.times_s is None:
            return False
        each = np.unique(self.times_s)
        whole = bool(np.all(each == np.round(each)))
        return not (whole and len(each) > 1 and float(np.median(np.diff(each))) == 1.0)


@dataclass(frozen=True, slots=True)
class _Columns:
    """Which column is what; `tracks` are those of the places of each thing in a row."""

    time: int | None
    frame: int | None
    thing: int | None
    tracks: tuple[tuple[int, ...], ...]


def read_track_table(path: Path) -> TrackTable:
    """Read the places in a tracker's table.

    Where the table's separator is no comma, one in a number is a decimal comma.

    Raises
    ------
    InputError
        It is no text, has no columns x and y, or no number below them; with the line.
    """
    rows, head, columns = _rows(path)
    below, first = rows[head + 1 :], columns.tracks[0][0]
    unit, time_unit = (_unit(rows[head], at) for at in (first, columns.time))
    found: list[tuple[float, float, list[float], str]] = []
    counted_rows = left = 0
    for number, row in enumerate(below):
        own = list(_places(row, columns))
        frame = counted_rows if columns.frame is None else _number(row, columns.frame)
        moment = 0.0 if columns.time is None else _number(row, columns.time)
        if own and math.isfinite(frame) and math.isfinite(moment):
            found += [(frame, moment, *each) for each in own]
        elif _is_text(row, columns):
            if found:
                left = sum(any(cell.strip() for cell in each) for each in below[number:])
                break
            # Trackers write names for people, and units, in lines of their own below the names.
            unit, time_unit = unit or _unit(row, first), time_unit or _unit(row, columns.time)
            continue
        # A row without places is a frame in which nothing was found.
        counted_rows += 1
    if not found:
        raise InputError(path, f"has no number below its names in line {head + 1}")
    frames, moments, places, things = zip(*found, strict=True)
    in_seconds = SECONDS.get(time_unit, 1.0) * np.array(moments)
    return TrackTable(
        frames=np.array(frames),
        times_s=None if columns.time is None else in_seconds,
        places=np.array(places),
        things=np.array(things),
        metres=METRES.get(unit),
        numbered=columns.frame is not None,
        notes=(f"{counted(left, 'line')} below the places were not read",) if left else (),
    )


def is_track_table(path: Path) -> bool:
    """Return whether a file is a table with columns of places."""
    if path.suffix.lower() not in TABLE_SUFFIXES or not path.is_file():
        return False
    try:
        _rows(path)
    except InputError:
        return False
    return True


def is_table_of_bounces(path: Path) -> bool:
    """Return whether a file's first line names times at which a ball was heard."""
    if path.suffix.lower() not in TABLE_SUFFIXES or not path.is_file():
        return False
    try:
        lines = read_lines(path)
    except InputError:
        return False
    cells = re.split("[\t;,]", lines[0].replace('"', "")) if lines else []
    return any(BOUNCE.fullmatch(cell.strip()) for cell in cells)


def read_lines(path: Path) -> list[str]:
    """Return the lines of a text.

    Raises
    ------
    InputError
        It cannot be read, is too large, or is no text.
    """
    try:
        if path.stat().st_size > MOST_BYTES:
            raise InputError(path, f"is larger than a table of {MOST_BYTES // 10**6} MB")
        data = path.read_bytes()
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror or error}") from error
    if data[:2] in {b"\xff\xfe", b"\xfe\xff"}:
        return data.decode("utf-16", errors="replace").splitlines()
    if b"\0" in data:
        raise InputError(path, "is no text")
    try:
        return data.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        return data.decode("latin-1").splitlines()


def split(lines: Sequence[str], separator: str) -> list[list[str]]:
    """Return the cells of lines; a comma within one is a decimal comma."""
    rows = csv.reader(lines, delimiter=separator, skipinitialspace=separator == " ")
    return [[cell.replace(",", ".") for cell in row] for row in rows]


def _rows(path: Path) -> tuple[list[list[str]], int, _Columns]:
    """Return the cells, the row of names, and what each column is."""
    lines = read_lines(path)
    for separator in "\t;, ":
        rows = split(lines, separator)
        for head, row in enumerate(rows):
            columns = _columns(row)
            if columns is not None:
                return rows, head, columns
    raise InputError(path, "has no line that names columns x and y")


def _columns(row: Sequence[str]) -> _Columns | None:
    """Return what a row of names says; None: it names no places."""
    names = [_plain(cell) for cell in row]
    tracks: list[list[int]] = []
    axes = ""
    order: dict[int, str] = {}
    for index, name in enumerate(names):
        place = PLACE.fullmatch(name)
        if place is None:
            continue
        if not tracks or place[1] in axes:
            tracks, axes = [*tracks, []], ""
        tracks[-1].append(index)
        order[index], axes = place[1], axes + place[1]
        tracks[-1].sort(key=order.__getitem__)
    kept = [track for track in tracks if len(track) == max(map(len, tracks))]
    if "shot" in names or not kept or len(kept[0]) < 2:
        return None
    time, frame, thing = (
        next((names.index(name) for name in known if name in names), None)
        for known in (TIMES, FRAMES, THINGS)
    )
    return _Columns(time, frame, thing, tuple(map(tuple, kept)))


def _plain(cell: str) -> str:
    """Return a column's name in lower case, without its unit and what is no letter or digit."""
    return re.sub(r"[^a-z0-9]", "", UNIT.sub("", cell.strip()).lower())


def _unit(row: Sequence[str], index: int | None) -> str:
    """Return the unit in a cell, in lower case; empty where there is none."""
    found = UNIT.search(row[index].strip()) if index is not None and index < len(row) else None
    return "" if found is None else (found[1] or found[2] or "").lower()


def _number(row: Sequence[str], index: int) -> float:
    try:
        return float(row[index].strip().replace("\u2212", "-"))
    except (ValueError, IndexError):
        return math.nan


def _places(row: Sequence[str], columns: _Columns) -> Iterator[tuple[list[float], str]]:
    """Give the places in a row, each with what it is of."""
    for number, track in enumerate(columns.tracks):
        place = [_number(row, index) for index in track]
        if all(map(math.isfinite, place)):
            own = columns.thing
            yield place, str(number) if own is None or own >= len(row) else row[own].strip()


def _is_text(row: Sequence[str], columns: _Columns) -> bool:
    """Return whether a row below the places is none of a frame in which nothing was found."""
    known = [index for index in (columns.frame, columns.time) if index is not None]
    cells = [row[i].strip().lower() for i in known or columns.tracks[0] if i < len(row)]
    return any(cell not in NONE and math.isnan(_number([cell], 0)) for cell in cells)
