"""`rigctl analyse`: frames or a campaign folder to poses, contacts and coefficients."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from analysis.campaign import (
    SHOT_LIST,
    Campaign,
    ShotJob,
    analyse_campaign,
    joined,
    read_campaign,
)
from analysis.errors import InputError
from analysis.exchange.description import read_description
from analysis.exchange.folder import folder_writer
from analysis.figures.shot import draw_shot
from analysis.imaging.edge.frame import EdgeSettings
from analysis.imaging.files.stack import read_stack
from analysis.shot import AnalysisOptions, MeasuredShot, Method, RefusedShot
from analysis.tracking import Matching
from rigctl.commands.analysis.analyse_output import ShotTable, shot_object
from rigctl.commands.analysis.compile_note import announce_compiling
from rigctl.commands.analysis.spool import Spool, print_document
from rigctl.errors import AnalysisInputError

Tell = Callable[[int, MeasuredShot | RefusedShot], None]


@dataclass(frozen=True, slots=True)
class Request:
    """What to analyse and where the results go.

    Attributes
    ----------
    paths
        Campaign folders, or frames.
    setup
        A campaign.toml for frames that belong to no campaign.
    sigma_px
        Width of the edge filter, thesis method alone; None: the default.
    samples_per_pixel
        Facet samples, thesis method alone; None: the exact root.
    matching
        How markers are matched, thesis method alone; None: the default.
    three_and_three
        The thesis's three frames before and after.
    out, figures
        Folders for the exchange files and for one picture a shot.
    workers
        Processes; None: one for each processor.
    method
        How images are measured.
    """

    paths: Sequence[Path]
    setup: Path | None = None
    sigma_px: float | None = None
    samples_per_pixel: int | None = None
    matching: Matching | None = None
    three_and_three: bool = False
    out: Path | None = None
    figures: Path | None = None
    workers: int | None = None
    method: Method = "photometric"


def analyse(request: Request, *, as_json: bool) -> None:
    """Analyse, write what is asked for, and print a table or one JSON document.

    Raises
    ------
    AnalysisInputError
        An option belongs to the other method; a path, a set-up or a campaign file cannot be read,
        or no shot's frames can. Then the refusal of each shot is printed first.
    StoreError
        The temporary folder is full.
    """
    _keep_sources(request)
    options = _options(request)
    with Spool() as objects, ShotTable() as table:

        def tell(number: int, shot: MeasuredShot | RefusedShot) -> None:
            if as_json:
                objects.add(shot_object(number, shot))
            else:
                table.add(number, shot)

        try:
            campaign = _gather(request)
            announce_compiling(request.method)
            started = time.perf_counter()
            frames = _run(request, campaign, options, tell)
            elapsed = time.perf_counter() - started
        except InputError as error:
            raise AnalysisInputError(error.reason, part=_place(error)) from error
        if as_json:
            head = {
                "campaign": campaign.name,
                "method": request.method,
                "frames_per_second": round(frames / elapsed, 1),
                "unlisted": [str(path) for path in campaign.unlisted],
            }
            print_document(head, "shots", objects)
        else:
            table.print(campaign.name)
    _name_unlisted(campaign)
    if frames == 0:
        raise AnalysisInputError(
            "no frames of any shot can be read",
            part=campaign.name,
            todo="the reason stands beside each shot",
        )


def _name_unlisted(campaign: Campaign) -> None:
    if campaign.unlisted:
        names = ", ".join(map(str, campaign.unlisted))
        note = f"rigctl: frames without a row in {SHOT_LIST}, left out: {names}"
        print(note, file=sys.stderr)  # noqa: T201


def _keep_sources(request: Request) -> None:
    """Refuse to write an exchange folder over a campaign that is read."""
    read = {place.resolve() for path in request.paths for place in (path, path.parent.parent)}
    if request.out is not None and request.out.resolve() in read:
        raise AnalysisInputError(
            "is the campaign that is read; its files would be replaced",
            part=str(request.out),
            todo="choose another folder for --out",
        )


def _place(error: InputError) -> str:
    return error.path if error.line is None else f"{error.path}, line {error.line}"


def _gather(request: Request) -> Campaign:
    """Read all paths into one campaign; loose files are numbered in the order given."""
    setup = None if request.setup is None else read_description(request.setup)[1]
    campaigns = [read_campaign(path, setup) for path in request.paths]
    return joined(campaigns)


def _options(request: Request) -> AnalysisOptions:
    """Return the analysis's options; refuse those that the method does not have."""
    if request.method == "thesis":
        edges = EdgeSettings(samples_per_pixel=request.samples_per_pixel)
        if request.sigma_px is not None:
            edges = replace(edges, sigma_px=request.sigma_px)
        return AnalysisOptions(edges, request.matching, request.three_and_three, "thesis")
    given = {
        "--sigma-px": request.sigma_px,
        "--samples": request.samples_per_pixel,
        "--matching": request.matching,
    }
    for name, value in given.items():
        if value is not None:
            raise AnalysisInputError(
                f"means nothing to the {request.method} method, which finds no edges",
                part=name,
                todo=f"leave {name} out, or add --method thesis",
            )
    return AnalysisOptions(three_and_three=request.three_and_three, method=request.method)


def _run(request: Request, campaign: Campaign, options: AnalysisOptions, tell: Tell) -> int:
    """Analyse shot after shot, write what is asked for and forget it; return how many frames.

    No folder is made for a campaign of which no frames can be read.
    """
    frames, write = 0, None
    bar = Progress(console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty())
    with ExitStack() as written, bar:
        task = bar.add_task("analysing", total=len(campaign.jobs))
        done = analyse_campaign(
            campaign,
            options,
            request.workers,
            progress=lambda count, _: bar.update(task, completed=count),
        )
        for job, shot, count in done:
            frames += count
            tell(job.shot, shot)
            if request.out is not None and write is None and count > 0:
                folder = folder_writer(request.out, campaign.name, campaign.jobs)
                write = written.enter_context(folder)
            if isinstance(shot, MeasuredShot):
                if write is not None:
                    write(job.shot, shot)
                if request.figures is not None:
                    _draw(request.figures, campaign.name, job, shot)
    return frames


def _draw(folder: Path, name: str, job: ShotJob, shot: MeasuredShot) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    frames = read_stack(job.frames).pixels
    draw_shot(folder / f"{job.shot:04d}.png", f"{name}, shot {job.shot}", frames, shot)
