"""`rigctl analyse` of films of one ball: on a plate, with or without a campaign's folder."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import Console
from rich.table import Table

from analysis.balls.analysis import AnalysedFilm, FilmJob, analyse_film
from analysis.balls.carried import NotFlyingError
from analysis.balls.document import Json, ball_document, positions
from analysis.balls.films.part import Cut
from analysis.balls.films.reading import film_of_shot
from analysis.balls.flight.known import Ball
from analysis.balls.lens.lens import read_lens
from analysis.campaign import DESCRIPTION, FRAMES, SHOT_LIST
from analysis.errors import InputError, ShotRefusedError
from analysis.exchange.description import read_description
from analysis.exchange.shot_list import EXPOSURE, read_shot_list
from analysis.figures.ball_film import draw_ball_film
from analysis.quantity import Quantity
from analysis.setup import Setup
from rigctl.errors import AnalysisInputError, SettingsError
from rigctl.measuring.own_film import stated_ball, write_ball_campaign

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
        Of the ball; None: every path is a campaign's folder.
    mass_g
        Of the ball; None: unknown, unless a folder states its density.
    rate_hz, exposure_us
        Of the camera; None: as the files say.
    window
        `x,y,w,h`: the part of the picture to look at.
    frames
        `A:B`: the frames to look at.
    lens
        lens.toml of the camera; None: pictures are taken as they are.
    figure
        File for a picture of the film; of several films, each has its number in the name.
    out
        Folder for campaign.toml, shots.csv and poses.csv: each film is a shot there.
    """

    paths: Sequence[Path]
    diameter_mm: float | None = None
    mass_g: float | None = None
    rate_hz: float | None = None
    exposure_us: float | None = None
    window: str | None = None
    frames: str | None = None
    lens: Path | None = None
    figure: Path | None = None
    out: Path | None = None


def is_ball_campaign(path: Path) -> bool:
    """Return whether a path is a campaign's folder whose sphere b is a plate, with frames."""
    if not (path / DESCRIPTION).exists() or not (path / FRAMES).exists():
        return False
    try:
        return read_description(path / DESCRIPTION)[1].spheres[1].plate
    except InputError:
        return False


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
    try:
        name, jobs = _jobs(request)
    except InputError as error:
        raise AnalysisInputError(error.reason, part=error.path) from error
    started = time.perf_counter()
    shots: list[Json] = []
    frames, unreadable, size = 0, None, (480, 640)
    for job in jobs:
        try:
            film = analyse_film(job)
        except InputError as error:
            unreadable = error
            shots.append(_refused(job, "frames", str(error)))
            continue
        except ShotRefusedError as refusal:
            shots.append(_refused(job, refusal.step, refusal.reason, refusal.frame))
            if isinstance(refusal, NotFlyingError) and refusal.placed is not None:
                shots[-1]["positions"] = positions(refusal.placed, refusal.times_s)
            continue
        frames += film.film.head.frames
        size = film.film.head.height, film.film.head.width
        shots.append({"shot": job.shot, **ball_document(film.measured, film.notes)})
        if request.figure is not None:
            _draw(request.figure, name, job, film, alone=len(jobs) == 1)
    elapsed = time.perf_counter() - started
    document = {
        "campaign": name,
        "method": METHOD,
        "frames_per_second": round(frames / elapsed, 1),
        "unlisted": [],
        "shots": shots,
    }
    if request.out is not None:
        _write(request.out, name, (jobs, size), shots)
    if as_json:
        print(json.dumps(document, allow_nan=False))  # noqa: T201
    else:
        _print(document)
    if unreadable is not None and frames == 0:
        raise AnalysisInputError(unreadable.reason, part=unreadable.path)


def _refused(job: FilmJob, step: str, reason: str, frame: int | None = None) -> Json:
    place = {} if frame is None else {"frame": frame}
    return {"shot": job.shot, "status": "refused", "step": step, **place, "reason": reason}


def _jobs(request: BallRequest) -> tuple[str, list[FilmJob]]:
    jobs: list[FilmJob] = []
    names = []
    for path in request.paths:
        if (path / DESCRIPTION).exists():
            name, setup = read_description(path / DESCRIPTION)
            names.append(name)
            jobs += _of_folder(path, setup, request)
        else:
            names.append(path.stem)
            number = int(path.stem) if path.stem.isdecimal() else len(jobs) + 1
            jobs.append(_job(number, path, _stated_ball(request), request))
    if len({job.shot for job in jobs}) < len(jobs):
        jobs = [replace(job, shot=number) for number, job in enumerate(jobs, start=1)]
    return "+".join(dict.fromkeys(names)), jobs


def _of_folder(folder: Path, setup: Setup, request: BallRequest) -> Iterator[FilmJob]:
    ball = Ball.of_setup(setup)
    if request.diameter_mm is not None:
        ball = _stated_ball(request)
    rows = read_shot_list(folder / SHOT_LIST)
    if not rows:
        raise InputError(folder / SHOT_LIST, "names no shots")
    for row in rows:
        job = _job(row.shot, film_of_shot(folder / FRAMES, row.shot), ball, request)
        exposure = row.numbers.get(EXPOSURE)
        if job.exposure_s is None and exposure is not None:
            job = replace(job, exposure_s=1e-6 * exposure)
        if job.rate_hz is None:
            job = replace(job, rate_hz=setup.camera.frame_rate_hz)
        yield job


def _job(number: int, path: Path, ball: Ball, request: BallRequest) -> FilmJob:
    exposure = request.exposure_us
    return FilmJob(
        shot=number,
        path=path,
        ball=ball,
        rate_hz=request.rate_hz,
        exposure_s=None if exposure is None else 1e-6 * exposure,
        cut=_cut(request),
        lens=None if request.lens is None else read_lens(request.lens),
    )


def _stated_ball(request: BallRequest) -> Ball:
    if request.diameter_mm is None:
        raise SettingsError(
            "is missing",
            part="--ball-diameter-mm",
            todo="state how large the ball is, as in --ball-diameter-mm 40",
        )
    return stated_ball(request.diameter_mm, request.mass_g)


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


def _write(folder: Path, name: str, films: Films, shots: Sequence[Json]) -> None:
    """Write the flights of all films; a folder that is read is not written over."""
    jobs, size = films
    if any(folder.resolve() in {job.path.resolve(), *job.path.resolve().parents} for job in jobs):
        raise AnalysisInputError(
            "holds the films that are read; its files would be replaced",
            part=str(folder),
            todo="choose another folder for --out",
        )
    write_ball_campaign(folder, name, jobs[0].ball, (jobs[0].rate_hz, size), shots)


def _draw(figure: Path, name: str, job: FilmJob, film: AnalysedFilm, *, alone: bool) -> None:
    path = figure if alone else figure.with_stem(f"{figure.stem}-{job.shot:04d}")
    path.parent.mkdir(parents=True, exist_ok=True)
    draw_ball_film(path, f"{name}, shot {job.shot}", film)


def _print(document: Json) -> None:
    console = Console(highlight=False, markup=False, soft_wrap=True)
    table = Table(title=document["campaign"], title_justify="left", box=None)
    for heading in ("shot", "bounce", "time s", "v_n m/s", "v_n' m/s", "e"):
        table.add_column(heading, justify="right", no_wrap=True)
    sentences = []
    for shot in document["shots"]:
        if shot["status"] == "refused":
            sentences.append(f"shot {shot['shot']} refused at {shot['step']}: {shot['reason']}")
            continue
        for number, each in enumerate(shot["impacts"], start=1):
            when = Quantity(each["contact_time_s"], each["contact_time_sigma_s"], "s").concise()
            cells = (_concise(each[key]) for key in ("v_n", "v_n_after", "e"))
            table.add_row(str(shot["shot"]), str(number), when, *cells)
        sentences += [f"shot {shot['shot']}: {note}" for note in shot["notes"]]
    table.caption = "in brackets: standard error in units of the last digit; spin, v_s, beta: open"
    console.print(table)
    for sentence in sentences:
        console.print(sentence)


def _concise(quantity: Json) -> str:
    return Quantity.from_json(quantity).concise()
