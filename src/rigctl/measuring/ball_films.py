"""Films of one ball as a person hands them over: which are some, and what is stated of each.

The command and Python share it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from analysis.balls.analysis import FilmJob
from analysis.balls.films.part import Cut
from analysis.balls.films.raw import RawLayout
from analysis.balls.films.reading import film_of_shot
from analysis.balls.flight.known import Ball, plate_lean
from analysis.balls.lens.lens import read_lens
from analysis.campaign import DESCRIPTION, FRAMES, POSES, SHOT_LIST
from analysis.errors import InputError
from analysis.exchange.description import read_description
from analysis.exchange.shot_list import EXPOSURE, ShotRow, read_shot_list
from analysis.setup import Setup
from rigctl.errors import SettingsError
from rigctl.measuring.own_film import stated_ball


@dataclass(frozen=True, slots=True)
class Stated:
    """What a person states of films of one ball.

    Attributes
    ----------
    diameter_mm
        Of the ball; None: as the set-up has it.
    mass_g
        Of the ball; None: unknown, unless the set-up states its density.
    rate_hz, exposure_us
        Of the camera; None: as the files say.
    cut
        Part of each film to look at; None: all of it.
    lens
        lens.toml of the camera; None: pictures are taken as they are.
    setup
        campaign.toml for films that lie in no campaign's folder.
    raw
        Pictures of films without a header.
    """

    diameter_mm: float | None = None
    mass_g: float | None = None
    rate_hz: float | None = None
    exposure_us: float | None = None
    cut: Cut | None = None
    lens: Path | None = None
    setup: Path | None = None
    raw: RawLayout | None = None


@dataclass(frozen=True, slots=True)
class BallFilms:
    """Films of one ball under a name, with their rows of shots.csv where they have any."""

    name: str
    jobs: Sequence[FilmJob]
    rows: Sequence[ShotRow]


def shows_one_ball(path: Path, setup: Path | None = None) -> bool:
    """Return whether sphere b of a campaign's folder, or of a film's set-up, is a plate."""
    home = _home(path)
    described = setup if home is None else home / DESCRIPTION
    try:
        return described is not None and read_description(described)[1].spheres[1].plate
    except InputError:
        return False


def ball_films(paths: Sequence[Path], stated: Stated) -> BallFilms:
    """Return the films of some campaigns' folders, or loose ones, each a shot.

    Shots are numbered in their order where two have the same number.

    Raises
    ------
    InputError
        A campaign's file, or the lens, cannot be read; a folder has no frames.
    SettingsError
        No diameter is stated.
    """
    jobs: list[FilmJob] = []
    rows: list[ShotRow] = []
    names = []
    for path in paths:
        home = _home(path)
        if home is None:
            names.append(path.stem)
            number = int(path.stem) if path.stem.isdecimal() else len(jobs) + 1
            known = None if stated.setup is None else read_description(stated.setup)[1]
            job = _job(number, path, _ball(stated, known), stated)
            own = [(job, ShotRow(number, None, {}, {}))]
        else:
            name, setup = read_description(home / DESCRIPTION)
            names.append(name)
            own = [
                (job, row)
                for job, row in _of_folder(home, setup, stated)
                if home == path or job.path.resolve() == path.resolve()
            ]
        jobs += [job for job, _ in own]
        rows += [row for _, row in own]
    if len({job.shot for job in jobs}) < len(jobs):
        jobs = [replace(job, shot=number) for number, job in enumerate(jobs, start=1)]
        rows = [replace(row, shot=number) for number, row in enumerate(rows, start=1)]
    return BallFilms("+".join(dict.fromkeys(names)), jobs, rows)


def _home(path: Path) -> Path | None:
    """Return the campaign's folder that is meant, or in whose `frames` a listed film lies."""
    if (path / DESCRIPTION).exists():
        return path
    home = path.resolve().parent.parent
    if path.resolve().parent.name != FRAMES or not (home / DESCRIPTION).exists():
        return None
    try:
        listed = {film_of_shot(home / FRAMES, row.shot) for row in read_shot_list(home / SHOT_LIST)}
    except InputError:
        return None
    return home if path.resolve() in {film.resolve() for film in listed} else None


def _of_folder(folder: Path, setup: Setup, stated: Stated) -> Iterator[tuple[FilmJob, ShotRow]]:
    if not (folder / FRAMES).exists():
        there = "holds poses and no frames; `rigctl model` reads it"
        raise InputError(folder, there if (folder / POSES).exists() else f"holds no {FRAMES}")
    ball = _ball(stated, setup)
    rows = read_shot_list(folder / SHOT_LIST)
    if not rows:
        raise InputError(folder / SHOT_LIST, "names no shots")
    for row in rows:
        job = _job(row.shot, film_of_shot(folder / FRAMES, row.shot), ball, stated)
        exposure = row.numbers.get(EXPOSURE)
        if job.exposure_s is None and exposure is not None:
            job = replace(job, exposure_s=1e-6 * exposure)
        if job.rate_hz is None:
            job = replace(job, rate_hz=setup.camera.frame_rate_hz)
        yield job, row


def _job(number: int, path: Path, ball: Ball, stated: Stated) -> FilmJob:
    exposure, rate = stated.exposure_us, stated.rate_hz
    if rate is None and stated.setup is not None:
        rate = read_description(stated.setup)[1].camera.frame_rate_hz
    return FilmJob(
        shot=number,
        path=path,
        ball=ball,
        rate_hz=rate,
        exposure_s=None if exposure is None else 1e-6 * exposure,
        cut=stated.cut,
        lens=None if stated.lens is None else read_lens(stated.lens),
        raw=stated.raw,
    )


def _ball(stated: Stated, setup: Setup | None) -> Ball:
    """Return the ball as it is stated, else as a set-up has it; the plate lies as that says."""
    if stated.diameter_mm is not None:
        ball = stated_ball(stated.diameter_mm, stated.mass_g)
        return ball if setup is None else replace(ball, plate_lean=plate_lean(setup))
    if setup is not None:
        return Ball.of_setup(setup)
    raise SettingsError(
        "is missing",
        part="the ball's diameter",
        todo="state how large the ball is: --ball-diameter-mm 40, in Python ball_diameter_mm=40",
    )
