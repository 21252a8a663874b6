"""`rigctl playback`: a film of a tape's playback to pictures with their recorded numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import tifffile
import typer

from analysis.balls.films.frames import read_frames
from analysis.errors import InputError
from analysis.imaging.fields import Scan, field_times
from analysis.imaging.playback.chain import Clock
from analysis.imaging.playback.recorded import Recorded, recorded_pictures
from analysis.imaging.playback.sampling import Sampling
from rigctl.cameras.capture_folder import StackNote
from rigctl.cli.options import Json
from rigctl.cli.output import print_json
from rigctl.errors import AnalysisInputError, SettingsError


def playback(
    film: Annotated[Path, typer.Argument(help="Film of the playback: AVI, MKV, MP4, TIFF, NPY.")],
    *,
    out: Annotated[
        Path, typer.Option(help="TIFF of the pictures; a JSON with numbers and times beside it.")
    ],
    recorded_per_s: Annotated[
        float, typer.Option(min=1.0, max=1e5, help="Pictures a second when the tape recorded.")
    ],
    film_per_s: Annotated[
        float, typer.Option(min=1.0, max=1e4, help="Frames a second of the film, 29.97 or 25.")
    ],
    shown_per_s: Annotated[
        float, typer.Option(min=0.5, max=1e3, help="Pictures a second of the playback.")
    ] = 30.0,
    scan: Annotated[
        Scan, typer.Option(help="Frames taken at once, or as two fields, which one first.")
    ] = "progressive",
    crop: Annotated[
        str | None, typer.Option(help="The picture in a frame: row,column,rows,columns.")
    ] = None,
    size: Annotated[str, typer.Option(help="Rows x columns of a recorded picture.")] = "192x240",
    first: Annotated[
        int, typer.Option(min=0, help="Recorded number of the picture on the first frame.")
    ] = 0,
    counted: Annotated[
        list[str] | None,
        typer.Option(help="FRAME=NUMBER that the recorder's overlay shows; any number of times."),
    ] = None,
    whole: Annotated[
        bool, typer.Option("--whole", help="The grabber is known to have left no frame out.")
    ] = False,
    json: Json = False,
) -> None:
    """Recognise repeats and skips, and write each picture once under its recorded number.

    Raises
    ------
    AnalysisInputError
        The film cannot be read, or no picture of it can be numbered.
    SettingsError
        An option is not of its form, or the crop lies outside the frames.
    """
    try:
        stack = read_frames(film)
    except InputError as error:
        raise AnalysisInputError(error.reason, part=error.path) from error
    frames, rows, columns = stack.pixels.shape
    high, wide = _numbers("--size", size, "x", 2)
    sampling = Sampling(_crop(crop, rows, columns), high, wide, scan)
    fields = [field for frame in stack.pixels for field in sampling.pictures(frame)]
    starts = np.arange(frames) / film_per_s if stack.times_s is None else stack.times_s
    times_s = field_times(starts, sampling.fields, 1 / film_per_s)
    known = {sampling.fields * frame: number for frame, number in _counted(counted or [])}
    told_by_times = whole or stack.times_s is not None
    clock = Clock(shown_per_s, first, known, 0 if told_by_times else sampling.fields)
    found = recorded_pictures(fields, times_s, clock)
    if not len(found.numbers):
        raise AnalysisInputError(
            "no picture can be given a number", part=str(film), todo=_advice(found, told_by_times)
        )
    _write(out, found, recorded_per_s)
    document = _document(film, out, found, sampling.fields)
    if json:
        print_json(document)
        return
    for line in _lines(found, sampling.fields, _advice(found, told_by_times)):
        print(line)  # noqa: T201


def _numbers(option: str, text: str, separator: str, count: int) -> tuple[int, ...]:
    parts = text.split(separator)
    if len(parts) != count or not all(part.strip().isdigit() for part in parts):
        raise SettingsError(
            "is not of its form",
            part=option,
            value=repr(text),
            limit=f"{count} whole numbers, {separator!r} between them",
        )
    return tuple(int(part) for part in parts)


def _crop(text: str | None, rows: int, columns: int) -> tuple[int, int, int, int]:
    if text is None:
        return 0, 0, rows, columns
    top, left, high, wide = _numbers("--crop", text, ",", 4)
    if min(high, wide) < 8 or top + high > rows or left + wide > columns:
        raise SettingsError(
            "does not lie in the film's frames",
            part="--crop",
            value=text,
            limit=f"at least 8 x 8 within {rows} rows and {columns} columns",
        )
    return top, left, high, wide


def _counted(texts: list[str]) -> list[tuple[int, int]]:
    pairs = [_numbers("--counted", text, "=", 2) for text in texts]
    return [(frame, number) for frame, number in pairs]


def _write(out: Path, found: Recorded, recorded_per_s: float) -> None:
    """Write the stack and its description (wire-protocol reference, capture folder)."""
    frames, rows, columns = found.pixels.shape
    note = StackNote(
        frames=frames,
        rows=rows,
        columns=columns,
        frame_rate_hz=recorded_per_s,
        sequence=tuple(found.numbers.tolist()),
        times_s=tuple((found.numbers / recorded_per_s).tolist()),
        lost=found.lost,
    )
    try:
        tifffile.imwrite(out, found.pixels, photometric="minisblack", metadata=None)
        out.with_suffix(".json").write_text(note.model_dump_json() + "\n", encoding="utf-8")
    except OSError as error:
        raise AnalysisInputError(f"cannot be written: {error.strerror}", part=str(out)) from error


def _document(film: Path, out: Path, found: Recorded, fields: int) -> dict[str, object]:
    return {
        "film": str(film),
        "out": str(out),
        "pictures": found.numbers.tolist(),
        "fields": found.fields.tolist(),
        "lost": list(found.lost),
        "doubtful": [
            {
                "first_frame": run.first // fields,
                "last_frame": run.last // fields,
                "number": run.number,
                "certainty": round(run.certainty, 4),
            }
            for run in found.doubtful
        ],
        "repeats_told": found.told,
    }


def _lines(found: Recorded, fields: int, advice: str) -> list[str]:
    first, last = found.numbers[[0, -1]]
    lines = [f"pictures {first} to {last}: {len(found.numbers)} found, {len(found.lost)} lost"]
    if found.lost:
        lines.append("lost: " + ", ".join(map(str, found.lost)))
    lines.extend(
        f"frames {run.first // fields} to {run.last // fields}: perhaps picture {run.number} "
        f"({run.certainty:.0%}), left out"
        for run in found.doubtful
    )
    return [*lines, advice] if found.doubtful else lines


def _advice(found: Recorded, told_by_times: bool) -> str:
    """Say what would make numbers certain."""
    if not found.told:
        return "repeats do not differ from new pictures: digitise without compression"
    ways = "name a number that the overlay shows with --counted FRAME=NUMBER"
    if told_by_times:
        return ways
    return f"{ways}, or --whole where the grabber is known to have left no frame out"
