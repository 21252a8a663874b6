"""`rigctl analyse` of films of one ball, or tables of one: on a plate, in a campaign or not."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table

from analysis.balls.analysis import FilmJob
from analysis.balls.carried import NotFlyingError
from analysis.balls.document import Json, positions
from analysis.balls.films.part import Cut
from analysis.balls.films.raw import EXAMPLE, RawLayout
from analysis.balls.tracks.table import is_table_of_bounces
from analysis.errors import InputError, ShotRefusedError
from analysis.quantity import Quantity
from rigctl.errors import AnalysisInputError, SettingsError
from rigctl.input_errors import as_analysis_errors
from rigctl.measuring.ball_films import Stated, ball_films
from rigctl.measuring.ball_results import ball_result
from rigctl.measuring.own_film import write_ball_campaign

METHOD = "ball"
Films = tuple[Sequence[FilmJob], tuple[int, int]]
"""With rows and columns of a picture."""


@dataclass(frozen=True, slots=True)
class BallRequest:
    """Films of one ball, and what a person states.

    Attributes
    ----------
    paths
        Films, or campaign folders whose sphere b is a plate.
    diameter_mm
        Of the ball; None: as the campaign's folder, or the set-up, has it.
    mass_g
        Of the ball; None: unknown, unless a folder states its density.
    rate_hz, exposure_us
        Of the camera; None: as the files say.
    setup
        campaign.toml for films that lie in no campaign's folder.
    window
        `x,y,w,h`: the part of the picture to look at.
    frames
        `A:B`: the frames to look at.
    lens
        lens.toml of the camera; None: pictures are taken as they are.
    figure
        File for a picture of the film; of several films, each has its number in the name.
    raw
        `WxHxBITS`: pictures of films without a header.
    out
        Folder for campaign.toml, shots.csv and poses.csv: each film is a shot there.
    """

    paths: Sequence[Path]
    diameter_mm: float | None = None
    mass_g: float | None = None
    rate_hz: float | None = None
    exposure_us: float | None = None
    setup: Path | None = None
    window: str | None = None
    frames: str | None = None
    lens: Path | None = None
    figure: Path | None = None
    raw: str | None = None
    out: Path | None = None


def refuse_options_of_a_ball(given: Mapping[str, object]) -> None:
    """Refuse options that two marked spheres do not have; raise `SettingsError`."""
    for name, value in given.items():
        if value is not None:
            raise SettingsError(
                "is for films of one ball",
                part=name,
                value=str(value),
                todo="state the ball too, with --ball-diameter-mm, or leave it out",
            )


def analyse_balls(request: BallRequest, *, as_json: bool) -> None:
    """Measure all films and print a table or one JSON document.

    Raises
    ------
    AnalysisInputError
        No film can be read, or a campaign's files cannot.
    SettingsError
        An option is no range.
    """
    stated = Stated(
        diameter_mm=request.diameter_mm,
        mass_g=request.mass_g,
        rate_hz=request.rate_hz,
        exposure_us=request.exposure_us,
        cut=_cut(request),
        lens=request.lens,
        setup=request.setup,
        raw=_layout(request.raw),
    )
    with as_analysis_errors():
        films = ball_films(request.paths, stated)
    name, jobs = films.name, films.jobs
    if request.figure is not None:
        _require_flights(jobs)
    started = time.perf_counter()
    shots: list[Json] = []
    frames, size = 0, (480, 640)
    for job in jobs:
        try:
            result = ball_result(job)
        except InputError as error:
            shots.append(_refused(job, "frames", str(error)))
            continue
        except ShotRefusedError as refusal:
            shots.append(_refused(job, refusal.step, refusal.reason, refusal.frame))
            if isinstance(refusal, NotFlyingError) and refusal.placed is not None:
                shots[-1]["positions"] = positions(refusal.placed, refusal.times_s)
            continue
        frames, size = frames + result.frames, result.size
        shots.append(result.document)
        if request.figure is not None and result.draw is not None:
            number = None if len(jobs) == 1 else job.shot
            _draw(request.figure, f"{name}, shot {job.shot}", result.draw, number)
    elapsed = time.perf_counter() - started
    rates = {shot["frame_rate_hz"] for shot in shots if "frame_rate_hz" in shot}
    document = {
        "campaign": name,
        "method": METHOD,
        "frame_rate_hz": rates.pop() if len(rates) == 1 else None,
        "frames_per_second": round(frames / elapsed, 1),
        "unlisted": [],
        "shots": shots,
    }
    if request.out is not None:
        _write(request.out, name, (jobs, size), shots)
    refused = [_sentence(shot) for shot in shots if shot["status"] == "refused"]
    nothing = len(refused) == len(shots)
    if as_json:
        print(json.dumps(document, allow_nan=False))  # noqa: T201
    elif not nothing or len(shots) > 1:
        _print(document)
    if nothing:
        raise nothing_measured(name, len(shots), refused[0])


def _require_flights(jobs: Sequence[FilmJob]) -> None:
    """Refuse to draw bounces that were heard; raise `SettingsError`."""
    for job in jobs:
        if is_table_of_bounces(job.path):
            raise SettingsError(
                "draws the flights of a ball, and bounces that were heard have none",
                part="--figure",
                value=job.path.name,
                todo="leave it out",
            )


def nothing_measured(
    name: str, shots: int, refusal: str, todo: str | None = None
) -> AnalysisInputError:
    """Return the error that ends a command of which no shot is measured.

    Parameters
    ----------
    refusal
        The sentence on the first shot, which is said here where there is no other.
    todo
        What may be missing of all of them.
    """
    if shots == 1:
        return AnalysisInputError(f"nothing is measured: {refusal}", part=name, todo=todo)
    beside = "the reason stands beside each shot"
    return AnalysisInputError(
        f"none of its {shots} shots is measured",
        part=name,
        todo=beside if todo is None else f"{beside}; {todo}",
    )


def _sentence(shot: Json) -> str:
    place = f", frame {shot['frame']}" if "frame" in shot else ""
    return f"shot {shot['shot']} refused at {shot['step']}{place}: {shot['reason']}"


def _refused(job: FilmJob, step: str, reason: str, frame: int | None = None) -> Json:
    place = {} if frame is None else {"frame": frame}
    return {"shot": job.shot, "status": "refused", "step": step, **place, "reason": reason}


def _cut(request: BallRequest) -> Cut | None:
    if request.frames is None and request.window is None:
        return None
    first, last = 0, None
    if request.frames is not None:
        try:
            a, b = request.frames.split(":")
            first, last = int(a or 0), int(b) if b else None
        except ValueError as error:
            raise SettingsError(
                "no range of frames",
                part="--frames",
                value=repr(request.frames),
                limit="two numbers with a colon between: the first, and the one after the last",
            ) from error
    window = None
    if request.window is not None:
        try:
            x, y, w, h = (int(part) for part in request.window.split(","))
        except ValueError as error:
            raise SettingsError(
                "no part of a picture",
                part="--roi",
                value=repr(request.window),
                limit="four whole numbers with commas between: column, row, width, height",
            ) from error
        window = (x, y, w, h)
    return Cut(first, last, window)


def _layout(said: str | None) -> RawLayout | None:
    try:
        return None if said is None else RawLayout.of(said)
    except ValueError as error:
        raise SettingsError(
            "is no picture",
            part="--raw",
            value=repr(said),
            limit="width, height and 12 or 16 bits of a pixel",
            todo=f"state it like {EXAMPLE}",
        ) from error


def _write(folder: Path, name: str, films: Films, shots: Sequence[Json]) -> None:
    """Write the flights of all films; a folder that is read is not written over."""
    jobs, size = films
    kinds = {"poses" in shot for shot in shots if shot.get("impacts")}
    if len(kinds) > 1:
        raise AnalysisInputError(
            "holds flights and bounces that were heard, of which one folder takes one kind",
            part=name,
            todo="write them with a command each, to two folders",
        )
    if any(folder.resolve() in {job.path.resolve(), *job.path.resolve().parents} for job in jobs):
        raise AnalysisInputError(
            "holds the films that are read; its files would be replaced",
            part=str(folder),
            todo="choose another folder for --out",
        )
    with _writing("--out", folder):
        write_ball_campaign(folder, name, jobs[0].ball, (jobs[0].rate_hz, size), shots)


def _draw(figure: Path, title: str, draw: Callable[[Path, str], None], number: int | None) -> None:
    path = figure if number is None else figure.with_stem(f"{figure.stem}-{number:04d}")
    with _writing("--figure", path):
        path.parent.mkdir(parents=True, exist_ok=True)
        draw(path, title)


@contextmanager
def _writing(option: str, place: Path) -> Iterator[None]:
    """Turn what a disk refuses into `SettingsError`."""
    try:
        yield
    except OSError as error:
        raise SettingsError(
            f"cannot be written: {error.strerror or error}",
            part=option,
            value=str(place),
            todo="name another place, or make room there",
        ) from error


def _print(document: Json) -> None:
    console = Console(highlight=False, markup=False, soft_wrap=True)
    table = Table(title=document["campaign"], title_justify="left", box=None)
    for heading in ("shot", "bounce", "time s", "v_n m/s", "v_n' m/s", "e"):
        table.add_column(heading, justify="right", no_wrap=True)
    sentences = []
    for shot in document["shots"]:
        if shot["status"] == "refused":
            sentences.append(_sentence(shot))
            continue
        for number, each in enumerate(shot["impacts"], start=1):
            when = Quantity(each["contact_time_s"], each["contact_time_sigma_s"], "s").concise()
            cells = (_concise(each[key]) for key in ("v_n", "v_n_after", "e"))
            table.add_row(str(shot["shot"]), str(number), when, *cells)
        sentences += [f"shot {shot['shot']}: {note}" for note in shot["notes"]]
    table.caption = "in brackets: standard error in units of the last digit; spin, v_s, beta: open"
    if table.row_count:
        console.print(table)
    for sentence in sentences:
        console.print(sentence)


def _concise(quantity: Json) -> str:
    return Quantity.from_json(quantity).concise()
