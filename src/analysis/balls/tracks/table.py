"""Tables of trackers: places by frame or time, whatever the program calls its columns.

Read are tables with a line of names: of Tracker (Open Source Physics), of ImageJ's Manual Tracking,
MTrack2 and TrackMate (as CSV), of trackpy, of DLTdv, of Logger Pro and Capstone, and any with
columns frame or t, x and y.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.tracks.cells import (
    NONE,
    is_no_number,
    moment,
    number,
    read_lines,
    split,
    time_code,
)
from analysis.balls.tracks.columns import (
    BOUNCE,
    COUNTED,
    METRES,
    PIXELS,
    SECONDS,
    Columns,
    columns_of,
    unit_of,
)
from analysis.errors import InputError, counted

TABLE_SUFFIXES = (".csv", ".tsv", ".txt", ".dat")
MOST_NAMED = 12
"""Columns that a refusal names."""
NOTHING = 0.0, -1.0
"""What trackers write as both numbers of a place where they found nothing."""
TELLING, LEAST_JUMP, MOST_STEPS = 10, 5.0, 0.9
"""Such a place says that nothing was found where so many others of the thing show that it
lies farther off those beside it than so many of the steps that so large a share stays below."""


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
        How the table was read, and what of it was not taken.
    times_in
        Unit of the times as the table states it; empty: it does not.
    """

    frames: Floats
    times_s: Floats | None
    places: Floats
    things: NDArray[np.str_]
    metres: float | None
    numbered: bool
    notes: tuple[str, ...]
    times_in: str = ""

    @property
    def states_times(self) -> bool:
        """Whether it has times; whole numbers, one after another, are numbers of frames."""
        if self.times_s is None:
            return False
        each = np.unique(self.times_s)
        whole = bool(np.all(each == np.round(each)))
        return not (whole and len(each) > 1 and float(np.median(np.diff(each))) == 1.0)


@dataclass(slots=True)
class _Read:
    """What is read of the rows below a line of names, row by row.

    Attributes
    ----------
    units, time_unit
        Of the first thing's axes, and of the times.
    found
        Frame, time, place, thing, and number of its line.
    rows
        Frames so far; a row without a place is one in which nothing was found.
    odd
        Lines and texts of cells that are no numbers.
    unread
        Where what is not read begins, and how many lines it has.
    """

    units: list[str]
    time_unit: str
    found: list[tuple[float, float, list[float], str, int]] = field(default_factory=list)
    rows: int = 0
    odd: list[tuple[int, str]] = field(default_factory=list)
    unread: tuple[int, str, int] | None = None


def read_track_table(path: Path) -> TrackTable:
    """Read the places in a tracker's table.

    Raises
    ------
    InputError
        It is no text, has no columns x and y, or no number below them; with the line.
    """
    rows, head, columns = _rows(path)
    read = _read(rows, head, columns)
    if not read.found:
        raise InputError(path, f"has no number below its names in line {head + 1}")
    if read.time_unit not in {*SECONDS, *COUNTED}:
        known = ", ".join(name for name in SECONDS if len(name) < len("secs"))
        raise InputError(
            path,
            f"has times in “{read.time_unit}”, and the units that are known are {known}: rename "
            f"the column “{rows[head][columns.time or 0].strip()}”",
        )
    frames, moments, places, things, lines = zip(*read.found, strict=True)
    metres, in_one, units_said = _one_unit(read.units)
    of = np.array(things)
    lost = _not_found(np.array(places), of)
    return TrackTable(
        frames=np.array(frames)[~lost],
        times_s=None
        if columns.time is None
        else SECONDS.get(read.time_unit, 1.0) * np.array(moments)[~lost],
        places=np.array(places)[~lost] * in_one,
        things=of[~lost],
        metres=metres,
        numbered=columns.frame is not None,
        notes=(*units_said, *_left_out(read, np.array(lines)[lost])),
        times_in="" if read.time_unit in COUNTED else read.time_unit,
    )


def _read(rows: Sequence[Sequence[str]], head: int, columns: Columns) -> _Read:
    """Return what stands below a line of names, up to where another table begins."""
    axes = columns.tracks[0]
    read = _Read([unit_of(rows[head], axis) for axis in axes], unit_of(rows[head], columns.time))
    for line, row in enumerate(rows[head + 1 :], start=head + 2):
        own = list(_places(row, columns))
        frame = read.rows if columns.frame is None else number(row, columns.frame)
        at = 0.0 if columns.time is None else moment(row, columns.time)
        if own and math.isfinite(frame) and math.isfinite(at):
            if columns.time is not None and time_code(row, columns.time) is not None:
                read.time_unit = "s"
            read.found += [(frame, at, *each, line) for each in own]
        elif (text := _text(row, columns)) is not None:
            if read.found:
                left = sum(any(cell.strip() for cell in each) for each in rows[line - 1 :])
                read.unread = line, text, left
                break
            # Trackers write names for people, and units, in lines of their own below the names.
            read.units = [
                unit or unit_of(row, axis) for unit, axis in zip(read.units, axes, strict=True)
            ]
            read.time_unit = read.time_unit or unit_of(row, columns.time)
            continue
        read.odd += [
            (line, row[index].strip())
            for track in columns.tracks
            for index in track
            if index < len(row) and is_no_number(row[index])
        ]
        read.rows += 1
    return read


def _one_unit(units: Sequence[str]) -> tuple[float | None, Floats, tuple[str, ...]]:
    """Return what a unit is in m, factors that bring all axes to it, and what there is to say.

    An axis that states no unit has that of the others.
    """
    same = np.ones(len(units))
    stated = [unit for unit in units if unit not in PIXELS]
    if unknown := [unit for unit in stated if unit not in METRES]:
        said = f"the table's unit “{unknown[0]}” is not known, and does not count"
        return None, same, (said,)
    if not stated:
        return None, same, ()
    if any(unit and unit in PIXELS for unit in units):
        return None, same, ("axes in pixels and in lengths: the table's unit does not count",)
    metres = METRES[stated[0]]
    own = np.array([METRES.get(unit, metres) for unit in units])
    if np.all(own == metres):
        return metres, same, ()
    said = f"axes in {' and '.join(dict.fromkeys(stated))}: all are brought to {stated[0]}"
    return metres, own / metres, (said,)


def _not_found(places: Floats, things: NDArray[np.str_]) -> NDArray[np.bool_]:
    """Return which places are 0, 0 far from those beside them: a tracker that found nothing."""
    lost = np.zeros(len(places), dtype=bool)
    nothing = np.any([np.all(places == each, axis=1) for each in NOTHING], axis=0)
    for thing in np.unique(things[nothing]):
        own = np.flatnonzero((things == thing) & ~nothing)
        zeros = np.flatnonzero((things == thing) & nothing)
        if len(own) < TELLING:
            continue
        steps = np.linalg.norm(np.diff(places[own], axis=0), axis=1)
        far = LEAST_JUMP * float(np.quantile(steps, MOST_STEPS))
        after = np.searchsorted(own, zeros)
        beside = np.stack([own[np.maximum(after - 1, 0)], own[np.minimum(after, len(own) - 1)]])
        lost[zeros] = np.linalg.norm(places[beside], axis=2).min(axis=0) > far
    return lost


def _left_out(read: _Read, lost: NDArray[np.intp]) -> Iterator[str]:
    """Say what of a table's rows was not read, or was taken for nothing."""
    if read.odd:
        line, text = read.odd[0]
        yield (
            f"{counted(len(read.odd), 'cell')} of places that hold no number, the first in line "
            f"{line}: “{text}”; nothing is taken to be found there"
        )
    if len(lost):
        yield (
            f"{counted(len(lost), 'place')} at exactly 0, 0 or -1, -1, far from those beside, the "
            f"first in line {lost[0]}: taken for frames in which nothing was found"
        )
    if read.unread is not None:
        line, text, left = read.unread
        yield (
            f"{counted(left, 'line')} below the places, from line {line} on (“{text}”), "
            f"{'was' if left == 1 else 'were'} not read"
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
    """Return whether a file's first line, blank ones apart, names times of bounces."""
    if path.suffix.lower() not in TABLE_SUFFIXES or not path.is_file():
        return False
    try:
        lines = read_lines(path)
    except InputError:
        return False
    first = next((line for line in lines if line.strip()), "")
    cells = re.split("[\t;,]", first.replace('"', ""))
    return any(BOUNCE.fullmatch(cell.strip()) for cell in cells)


def _rows(path: Path) -> tuple[list[list[str]], int, Columns]:
    """Return the cells, the row of names, and what each column is."""
    lines = read_lines(path)
    empty: tuple[list[list[str]], int, Columns] | None = None
    for separator in "\t;, ":
        rows = split(lines, separator)
        for head, row in enumerate(rows):
            columns = columns_of(row)
            if columns is None:
                continue
            if any(any(_places(below, columns)) for below in rows[head + 1 :]):
                return rows, head, columns
            empty = empty or (rows, head, columns)
            break
    if empty is not None:
        return empty
    raise InputError(path, f"has no line that names columns x and y{_named(lines)}")


def _named(lines: Sequence[str]) -> str:
    """Say which columns a table has, and what to do about them; nothing of an empty one."""
    first = next((line for line in lines if line.strip()), None)
    if first is None:
        return ""
    rows = [[cell.strip() for cell in split([first], separator)[0]] for separator in "\t;, "]
    # Names hold blanks, too.
    names = next((row for row in rows if len(row) > 1), rows[0])
    if all(math.isfinite(moment(names, index)) for index in range(len(names))):
        return (
            f"; its first line holds {counted(len(names), 'number')} and no names: put a line "
            "such as frame,x,y above it"
        )
    if names[0].lower().startswith("bounce"):
        return (
            "; bounces that were heard stand in one row below Bounce 0 (s), Bounce 1 (s) and so on"
        )
    more = ", …" if len(names) > MOST_NAMED else ""
    return (
        f"; its columns are {', '.join(f'“{name}”' for name in names[:MOST_NAMED])}{more}: rename "
        "those of the ball's places to x and y, and those of its frames or times to frame or t (s)"
    )


def _places(row: Sequence[str], columns: Columns) -> Iterator[tuple[list[float], str]]:
    """Give the places in a row, each with what it is of."""
    for name, track in enumerate(columns.tracks):
        place = [number(row, index) for index in track]
        if all(map(math.isfinite, place)):
            own = columns.thing
            yield place, str(name) if own is None or own >= len(row) else row[own].strip()


def _text(row: Sequence[str], columns: Columns) -> str | None:
    """Return the text of a row that is none of a frame; None: it is one."""
    known = [index for index in (columns.frame, columns.time) if index is not None]
    cells = [row[i].strip() for i in known or columns.tracks[0] if i < len(row)]
    return next((c for c in cells if c.lower() not in NONE and is_no_number(c)), None)
