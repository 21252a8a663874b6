"""`rigctl analyse`: frames or a campaign folder to poses, contacts and coefficients."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from analysis.campaign import SHOT_LIST, Campaign, ShotJob, analyse_campaign, read_campaign
from analysis.compiled import kept_on_disk
from analysis.document import shot_document
from analysis.errors import InputError
from analysis.exchange.description import read_description
from analysis.exchange.folder import write_folder
from analysis.figures.shot import draw_shot
from analysis.imaging.frame import EdgeSettings
from analysis.imaging.markers import dark_ellipses
from analysis.imaging.stack import read_stack
from analysis.quantity import Quantity
from analysis.shot import AnalysisOptions, MeasuredShot, Method, RefusedShot
from analysis.tracking import Matching
from rigctl.errors import AnalysisInputError

TABLE_WIDTH = 100
"""A narrower terminal wraps the rows; cut digits would be wrong numbers."""
HEADINGS = (
    *("shot", "contact\nms", "v_n\nm/s", "v_s\nm/s", "v_n'\nm/s", "v_s'\nm/s"),
    *("e", "beta"),
)


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
    """
    _keep_sources(request)
    options = _options(request)
    try:
        campaign = _gather(request)
        _announce_compiling(request.method)
        started = time.perf_counter()
        results, frames = _run(campaign, options, request.workers)
        elapsed = time.perf_counter() - started
        if request.out is not None and frames > 0:
            write_folder(request.out, campaign.name, results)
        if request.figures is not None:
            _draw(request.figures, campaign.name, results)
    except InputError as error:
        raise AnalysisInputError(error.reason, part=_place(error)) from error
    if as_json:
        document = {
            "campaign": campaign.name,
            "method": request.method,
            "frames_per_second": round(frames / elapsed, 1),
            "unlisted": [str(path) for path in campaign.unlisted],
            "shots": [{"shot": job.shot, **shot_document(shot)} for job, shot in results],
        }
        print(json.dumps(document, allow_nan=False))  # noqa: T201
    else:
        _print_table(campaign.name, results)
    _name_unlisted(campaign)
    if frames == 0:
        raise AnalysisInputError(
            "no frames of any shot can be read",
            part=campaign.name,
            todo="the reason stands beside each shot",
        )


def _announce_compiling(method: Method) -> None:
    """Say why the first analysis on a machine is slow."""
    if method == "photometric":
        # Compiled functions are loaded only where they are wanted.
        from analysis.photometric.method import compiles_first  # noqa: PLC0415

        first, wait = compiles_first(), "about a minute"
    else:
        first, wait = not kept_on_disk(dark_ellipses), "about ten seconds"
    if first:
        note = f"rigctl: first {method} analysis here; compiling takes {wait}, once"
        print(note, file=sys.stderr)  # noqa: T201


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
    if len(campaigns) == 1:
        return campaigns[0]
    jobs: list[ShotJob] = [job for campaign in campaigns for job in campaign.jobs]
    if len({job.shot for job in jobs}) < len(jobs):
        jobs = [replace(job, shot=number) for number, job in enumerate(jobs, start=1)]
    names = list(dict.fromkeys(campaign.name for campaign in campaigns))
    unlisted = tuple(path for campaign in campaigns for path in campaign.unlisted)
    return Campaign("+".join(names), tuple(jobs), unlisted)


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


def _run(
    campaign: Campaign, options: AnalysisOptions, workers: int | None
) -> tuple[list[tuple[ShotJob, MeasuredShot | RefusedShot]], int]:
    console = Console(stderr=True)
    results, frames = [], 0
    with Progress(console=console, transient=True, disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task("analysing", total=len(campaign.jobs))
        done = analyse_campaign(
            campaign,
            options,
            workers,
            progress=lambda count, _: bar.update(task, completed=count),
        )
        for job, shot, count in done:
            results.append((job, shot))
            frames += count
    return results, frames


def _draw(
    folder: Path, name: str, results: Sequence[tuple[ShotJob, MeasuredShot | RefusedShot]]
) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for job, shot in results:
        if isinstance(shot, MeasuredShot):
            frames = read_stack(job.frames).pixels
            draw_shot(folder / f"{job.shot:04d}.png", f"{name}, shot {job.shot}", frames, shot)


def _print_table(name: str, results: Sequence[tuple[ShotJob, MeasuredShot | RefusedShot]]) -> None:
    table = Table(title=name, title_justify="left", box=None, padding=(0, 1, 0, 0))
    for heading in HEADINGS:
        table.add_column(heading, justify="right", no_wrap=True)
    refused = []
    for job, shot in results:
        if isinstance(shot, RefusedShot):
            refused.append((job.shot, shot))
            continue
        impact = shot.impact
        contact = Quantity(1e3 * impact.contact_time.value, 1e3 * impact.contact_time.sigma, "ms")
        cells = (contact, impact.v_n, impact.v_s, impact.v_n_after, impact.v_s_after, impact.e)
        beta = "" if impact.beta is None else impact.beta.concise()
        table.add_row(str(job.shot), *(cell.concise() for cell in cells), beta)
    table.caption = "in brackets: standard error in units of the last digit"
    console = Console()
    console.width = max(console.width, TABLE_WIDTH)
    console.print(table)
    for number, shot in refused:
        place = "" if shot.frame is None else f", frame {shot.frame}"
        console.print(f"shot {number} refused at {shot.step}{place}: {shot.reason}", markup=False)
