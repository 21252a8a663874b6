"""Every shot of a campaign, each on its own: one that fails does not stop the rest."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator, Sequence, Set
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, overload

import numpy as np

from analysis.arrays import Floats, Grey
from analysis.balls.films.frames import FRAME_SUFFIXES, holds_frames, read_frames
from analysis.errors import InputError, ShotRefusedError
from analysis.exchange.description import read_description
from analysis.exchange.shot_list import EXPOSURE, ShotRow, each_shot_row
from analysis.setup import CameraSetup, Setup, SphereSetup, without_exposure
from analysis.shot import AnalysisOptions, MeasuredShot, RefusedShot, analyse_shot, check_frames
from analysis.workers import Workers

if TYPE_CHECKING:
    from analysis.photometric.learn.appearance import Appearance


DESCRIPTION = "campaign.toml"
SHOT_LIST = "shots.csv"
FRAMES = "frames"
POSES = "poses.csv"
TEACHING_SHOTS = 6
"""Shots from which the photometric method learns the spheres before it measures any: of three, some
show a marker in no frame, and later shots that turn it to the camera are the worse for it."""
AHEAD = 4
"""Shots under way for each process: results of no more are held."""


@dataclass(frozen=True, slots=True)
class ShotJob:
    """One shot to be analysed: its number, where its frames lie, its set-up and settings."""

    shot: int
    frames: Path
    setup: Setup
    row: ShotRow | None = None


@dataclass(frozen=True, slots=True)
class Campaign:
    """Shots that share a set-up.

    Attributes
    ----------
    name, jobs
        As the campaign's files have them.
    unlisted
        Frames that lie in the campaign's folder and have no row in shots.csv.
    """

    name: str
    jobs: Sequence[ShotJob]
    unlisted: tuple[Path, ...] = ()


class ListedJobs(Sequence[ShotJob]):
    """The shots of a campaign's folder, made from shots.csv as they are gone through: none is held.

    Parameters
    ----------
    folder
        With shots.csv, which is checked now and read again each time, and frames.
    setup
        That all shots share, but for their exposures.

    Raises
    ------
    InputError
        As `read_shot_list`.
    """

    def __init__(self, folder: Path, setup: Setup) -> None:
        self._folder, self._setup = folder, setup
        self._count = sum(1 for _ in each_shot_row(folder / SHOT_LIST))

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[ShotJob]:
        for row in each_shot_row(self._folder / SHOT_LIST):
            setup = self._setup
            if (exposure := row.numbers.get(EXPOSURE)) is not None:
                setup = replace(setup, camera=replace(setup.camera, exposure_s=exposure * 1e-6))
            yield ShotJob(row.shot, frames_of(self._folder / FRAMES, row.shot), setup, row)

    @overload
    def __getitem__(self, index: int) -> ShotJob: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[ShotJob]: ...
    def __getitem__(self, index: int | slice) -> ShotJob | Sequence[ShotJob]:
        return tuple(self)[index]


THESIS_SETUP = Setup(
    camera=CameraSetup(
        frame_rate_hz=1000.0,
        height_px=192,
        width_px=240,
        front_view_rows=(88, 192),
        top_view_rows=(0, 88),
    ),
    spheres=(SphereSetup("a", 0.0254), SphereSetup("b", 0.0254)),
)
"""The second apparatus of the thesis: the set-up of frames that come without one."""


def shows_something_else(campaign: Campaign) -> bool:
    """Return whether frames may show other bodies than those of the thesis, for which they passed.

    Nobody said what they show, and they can be read.
    """
    job = next(iter(campaign.jobs))
    if job.setup != THESIS_SETUP:
        return False
    try:
        read_frames(job.frames)
    except InputError:
        return False
    return True


def read_campaign(path: Path, setup: Setup | None = None) -> Campaign:
    """Find the shots of a campaign folder, or take one file or folder of frames as one shot.

    Parameters
    ----------
    path
        A folder with campaign.toml, or frames. Frames inside a campaign's own `frames` folder take
        that campaign's set-up.
    setup
        For frames that belong to no campaign; None: the thesis's second apparatus.

    Raises
    ------
    InputError
        Nothing is there, the campaign's files cannot be read, or it holds poses in the place of
        frames.
    """
    if (path / DESCRIPTION).exists():
        return _campaign_folder(path)
    if not path.exists():
        raise InputError(path, "no such file or folder")
    number = int(path.stem) if path.stem.isdecimal() else 1
    home = path.resolve().parent.parent
    if path.resolve().parent.name == FRAMES and (home / DESCRIPTION).exists():
        whole = _campaign_folder(home)
        mine = [job for job in whole.jobs if job.frames.resolve() == path.resolve()]
        if mine:
            return Campaign(whole.name, (replace(mine[0], frames=path),))
    if path.is_dir() and not holds_frames(path):
        raise InputError(path, f"neither {DESCRIPTION} nor PNG or DNG frames are in this folder")
    return Campaign(path.stem, (ShotJob(number, path, setup or THESIS_SETUP),))


def joined(campaigns: Sequence[Campaign]) -> Campaign:
    """Return several campaigns, or single films, as one.

    Shots are numbered in their order where two have the same number.
    """
    if len(campaigns) == 1:
        return campaigns[0]
    jobs = [job for campaign in campaigns for job in campaign.jobs]
    if len({job.shot for job in jobs}) < len(jobs):
        jobs = [replace(job, shot=number) for number, job in enumerate(jobs, start=1)]
    names = list(dict.fromkeys(campaign.name for campaign in campaigns))
    unlisted = tuple(path for campaign in campaigns for path in campaign.unlisted)
    return Campaign("+".join(names), tuple(jobs), unlisted)


def _campaign_folder(path: Path) -> Campaign:
    name, setup = read_description(path / DESCRIPTION)
    if (path / POSES).exists() and not (path / FRAMES).exists():
        raise InputError(path, "the folder holds poses and no frames; `rigctl model` reads it")
    if any(sphere.plate for sphere in setup.spheres):
        raise InputError(
            path / DESCRIPTION,
            "spheres: b is a plate; a film of one ball is measured by `rigctl analyse`, apart from "
            "films of two spheres",
        )
    jobs = ListedJobs(path, setup)
    if len(jobs) == 0:
        raise InputError(path / SHOT_LIST, "names no shots")
    listed = {row.shot for row in each_shot_row(path / SHOT_LIST)}
    return Campaign(name, jobs, _unlisted(path / FRAMES, listed))


def _unlisted(folder: Path, shots: Set[int]) -> tuple[Path, ...]:
    """Return what lies in a folder of frames and belongs to none of these shots."""

    def is_listed(stem: str) -> bool:
        return stem.isdecimal() and int(stem) in shots and stem == f"{int(stem):04d}"

    entries = folder.iterdir() if folder.is_dir() else ()
    unlisted = (entry for entry in entries if not is_listed(entry.stem))
    return tuple(
        sorted(
            entry
            for entry in unlisted
            if (holds_frames(entry) if entry.is_dir() else entry.suffix.lower() in FRAME_SUFFIXES)
        )
    )


def frames_of(folder: Path, shot: int) -> Path:
    """Return where a shot's frames lie; the plain TIFF name where nothing is there."""
    stem = folder / f"{shot:04d}"
    candidates = [stem.with_suffix(suffix) for suffix in FRAME_SUFFIXES]
    return next((c for c in (*candidates, stem) if c.exists()), stem.with_suffix(".tiff"))


def analyse_job(
    job: ShotJob, options: AnalysisOptions, known: Appearance | None = None
) -> tuple[MeasuredShot | RefusedShot, int]:
    """Analyse one shot from its files; frames that cannot be read refuse it.

    Parameters
    ----------
    known
        Sphere appearance learned from earlier shots of the same spheres and camera.

    Returns
    -------
    The result, and how many frames were read.
    """
    try:
        read = read_job(job)
    except InputError as error:
        return RefusedShot("frames", str(error), None), 0
    result = analyse_shot(read.frames, read.times_s, read.setup, options, known)
    if isinstance(result, MeasuredShot):
        result = replace(result, notes=(*read.notes, *result.notes))
    return result, len(read.frames)


@dataclass(frozen=True, slots=True, eq=False)
class ReadShot:
    """Frames of a shot, grey, shape (frames, rows, columns), and what comes with them.

    Attributes
    ----------
    times_s
        Of each frame, s, shape (frames,): the film's own, else by the stated rate.
    setup
        With the exposure that is stated, else that of the film's own file.
    notes
        On the file.
    """

    frames: Grey
    times_s: Floats
    setup: Setup
    notes: tuple[str, ...]


def read_job(job: ShotJob) -> ReadShot:
    """Read the frames of a shot.

    Raises
    ------
    InputError
        As `read_frames`.
    """
    stack, setup = read_frames(job.frames), job.setup
    times = stack.times_s
    if times is None:
        times = np.arange(len(stack.pixels)) / setup.camera.frame_rate_hz
    if setup.camera.exposure_s is None and stack.exposure_s is not None:
        setup = replace(setup, camera=replace(setup.camera, exposure_s=stack.exposure_s))
    return ReadShot(stack.light, times, setup, stack.notes)


def training_jobs(jobs: Sequence[ShotJob]) -> dict[Setup, list[ShotJob]]:
    """Return the training shots of the photometric method for each set-up, exposure aside."""
    by_setup: dict[Setup, list[ShotJob]] = {}
    for job in jobs:
        own = by_setup.setdefault(without_exposure(job.setup), [])
        if len(own) < TEACHING_SHOTS:
            own.append(job)
    return by_setup


def _known(jobs: Sequence[ShotJob]) -> dict[Setup, Appearance | None]:
    """Return the sphere appearance learned from the first shots of each set-up, exposure aside."""
    # Loading compiled functions is slow; the thesis method needs none of these.
    from analysis.photometric.teaching import teach  # noqa: PLC0415

    known: dict[Setup, Appearance | None] = {}
    for setup, own in training_jobs(jobs).items():
        shots = []
        for job in own:
            with suppress(InputError, ShotRefusedError):
                read = read_job(job)
                check_frames(read.frames, read.times_s, read.setup)
                shots.append((read.frames, read.times_s - read.times_s[0], read.setup))
        known[setup] = teach(shots) if len(own) > 1 else None
    return known


def analyse_campaign(
    campaign: Campaign,
    options: AnalysisOptions,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    but: Set[int] = frozenset(),
) -> Iterator[tuple[ShotJob, MeasuredShot | RefusedShot, int]]:
    """Analyse all shots, in their order; few results are held at any time.

    A script needs no `if __name__ == "__main__":` around it.

    Parameters
    ----------
    workers
        Number of processes; None: one for each processor, and no extra one for one or two shots.
    progress
        Called with the number of shots done and of all shots.
    but
        Numbers of shots that are not analysed again; training shots among them are still read.

    Yields
    ------
    The job, its result, and the number of its frames.

    Raises
    ------
    WorkerDiedError
        A process was killed.
    """
    known = {} if options.method == "thesis" else _known(campaign.jobs)
    jobs = [job for job in campaign.jobs if job.shot not in but] if but else campaign.jobs
    total = len(jobs)
    count = min(workers or os.cpu_count() or 1, total)
    if count <= 1 or (workers is None and total <= 2):
        for done, job in enumerate(jobs, start=1):
            result, frames = analyse_job(job, options, known.get(without_exposure(job.setup)))
            if progress is not None:
                progress(done, total)
            yield job, result, frames
        return
    with Workers(count) as pool:
        left = iter(jobs)
        waiting: deque[tuple[ShotJob, Future[tuple[MeasuredShot | RefusedShot, int]]]] = deque()
        for done in range(1, total + 1):
            for job in islice(left, count * AHEAD - len(waiting)):
                own = known.get(without_exposure(job.setup))
                waiting.append((job, pool.submit(analyse_job, job, options, own)))
            job, future = waiting.popleft()
            result, frames = future.result()
            if progress is not None:
                progress(done, total)
            yield job, result, frames
