"""`rigctl analyse`: frames or a campaign folder to poses, contacts and coefficients."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Self

import typer
from rich.console import Console
from rich.progress import Progress

from analysis.balls.films.frames import read_frames
from analysis.campaign import (
    SHOT_LIST,
    Campaign,
    ShotJob,
    analyse_campaign,
    joined,
    read_campaign,
    shows_something_else,
)
from analysis.document import shot_document
from analysis.errors import InputError
from analysis.exchange.description import read_description
from analysis.exchange.folder import folder_writer
from analysis.imaging.edge.frame import EdgeSettings
from analysis.shot import AnalysisOptions, MeasuredShot, RefusedShot
from analysis.tracking import Matching
from rigctl.cli.frames.balls import (
    BallRequest,
    analyse_balls,
    nothing_measured,
    refuse_options_of_a_ball,
)
from rigctl.cli.frames.compile_note import announce_compiling
from rigctl.cli.options import Json, MeasuredBy, Method, Workers
from rigctl.cli.spool import Spool, print_document
from rigctl.errors import AnalysisInputError, SettingsError
from rigctl.measuring.ball_films import shows_one_ball

HEADINGS = (
    *("shot", "contact\nms", "lasts\nus", "v_n\nm/s", "v_s\nm/s", "v_n'\nm/s", "v_s'\nm/s"),
    *("e", "beta"),
)
_CAPTION = "in brackets: standard error in units of the last digit"
_CELL = "\t"
OTHER_FILMS = (
    "frames without a set-up are taken for those of two marked spheres of 25.4 mm: of a ball that "
    "bounces state the diameter, --ball-diameter-mm 40; of other spheres --setup campaign.toml"
)


def shot_object(number: int, shot: MeasuredShot | RefusedShot) -> str:
    """Return the result of a shot as a JSON object on one line."""
    return json.dumps({"shot": number, **shot_document(shot)}, allow_nan=False)


def refusal(number: int, shot: RefusedShot) -> str:
    """Return the sentence on a refused shot."""
    place = "" if shot.frame is None else f", frame {shot.frame}"
    return f"shot {number} refused at {shot.step}{place}: {' '.join(shot.reason.split())}"


class ShotTable:
    """A row for each measured shot and a sentence for each refused one.

    Every method raises `StoreError` where the temporary folder is full.
    """

    def __init__(self) -> None:
        self._files = ExitStack()
        self._rows = self._files.enter_context(Spool())
        self._refused = self._files.enter_context(Spool())
        self._headings = [heading.partition("\n") for heading in HEADINGS]
        self._widths = [max(len(name), len(unit)) for name, _, unit in self._headings]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._files.close()

    def add(self, number: int, shot: MeasuredShot | RefusedShot) -> None:
        """Append a shot."""
        if isinstance(shot, RefusedShot):
            self._refused.add(refusal(number, shot))
            return
        cells = _cells(number, shot)
        self._widths = [max(w, len(cell)) for w, cell in zip(self._widths, cells, strict=True)]
        self._rows.add(_CELL.join(cells))

    def print(self, title: str) -> None:
        """Print all of it."""
        console = Console(highlight=False, markup=False, soft_wrap=True)
        console.print(title, style="italic")
        for part in (0, 2):
            console.print(self._line([heading[part] for heading in self._headings]), style="bold")
        for row in self._rows.lines():
            console.print(self._line(row.split(_CELL)))
        console.print(_CAPTION, style="dim")
        for sentence in self._refused.lines():
            console.print(sentence)

    def _line(self, cells: list[str]) -> str:
        return " ".join(cell.rjust(w) for cell, w in zip(cells, self._widths, strict=True))


def _cells(number: int, shot: MeasuredShot) -> list[str]:
    impact = shot.impact
    cells = (
        impact.contact_time.rescaled(1e3, "ms"),
        None if impact.duration is None else impact.duration.rescaled(1e6, "us"),
        *(impact.v_n, impact.v_s, impact.v_n_after, impact.v_s_after, impact.e, impact.beta),
    )
    return [str(number), *("" if cell is None else cell.concise() for cell in cells)]


Shot = MeasuredShot | RefusedShot
Done = tuple[ShotJob, Shot, int]


def analyse(
    paths: Annotated[
        list[Path],
        typer.Argument(
            help="Campaign folders, films (MP4, MOV, AVI, CINE, TIFF, NPY, PNG folder), or a "
            "tracker's table of a ball as CSV."
        ),
    ],
    *,
    method: MeasuredBy = "photometric",
    setup: Annotated[
        Path | None,
        typer.Option(help="A campaign.toml for frames that belong to no campaign folder."),
    ] = None,
    sigma_px: Annotated[
        float | None,
        typer.Option(min=0.5, max=8.0, help="Thesis method: width of the edge filter, pixels."),
    ] = None,
    samples: Annotated[
        int | None,
        typer.Option(min=1, max=16, help="Thesis method: facet samples a pixel. Default: exact."),
    ] = None,
    matching: Annotated[
        Matching | None,
        typer.Option(help="Thesis method: markers by rigid pattern, or frame to frame."),
    ] = None,
    three: Annotated[
        bool, typer.Option("--three", help="Three frames before and three after, 2 ms apart.")
    ] = False,
    out: Annotated[
        Path | None, typer.Option(help="Write an exchange folder with poses and contacts here.")
    ] = None,
    figures: Annotated[
        Path | None, typer.Option(help="Write one picture a shot into this folder.")
    ] = None,
    workers: Workers = None,
    ball_diameter_mm: Annotated[
        float | None,
        typer.Option(min=0.1, max=2000.0, help="A film of one ball that bounces: its diameter."),
    ] = None,
    plate: Annotated[
        bool, typer.Option("--plate", help="The ball bounces on a plate, floor or table (default).")
    ] = False,
    ball_mass_g: Annotated[
        float | None, typer.Option(min=1e-6, help="Mass of the ball: its drag in air follows.")
    ] = None,
    fps: Annotated[
        float | None,
        typer.Option(min=0.1, max=1e8, help="Frames a second of the camera, not of the player."),
    ] = None,
    exposure_us: Annotated[
        float | None, typer.Option(min=0.0, help="Exposure of a ball's film; else from its smear.")
    ] = None,
    roi: Annotated[
        str | None, typer.Option(help="Part of a ball's film to look at: column,row,width,height.")
    ] = None,
    frames: Annotated[
        str | None, typer.Option(help="Frames of a ball's film to look at: first:after-last.")
    ] = None,
    lens: Annotated[
        Path | None,
        typer.Option(help="Lens of a ball's film: lens.toml of `rigctl calibrate --board`."),
    ] = None,
    raw: Annotated[
        str | None,
        typer.Option(help="Pictures of a .raw film: width x height x bits, 1280x1024x12."),
    ] = None,
    figure: Annotated[
        Path | None, typer.Option(help="A picture of a ball's film with flights and bounces.")
    ] = None,
    json: Json = False,
) -> None:
    """Analyse, write what is asked for, and print a table or one JSON document.

    Raises
    ------
    AnalysisInputError
        An option belongs to the other method; a path, a set-up or a campaign file cannot be read,
        or no shot's frames can. Then the refusal of each shot is printed first.
    SettingsError
        Something cannot be written where it is wanted, or an option is no range.
    StoreError
        The temporary folder is full.
    """
    _require_places(out, figures, figure)
    if ball_diameter_mm is not None or plate or all(shows_one_ball(path, setup) for path in paths):
        asked = BallRequest(
            paths=paths,
            diameter_mm=ball_diameter_mm,
            mass_g=ball_mass_g,
            rate_hz=fps,
            exposure_us=exposure_us,
            setup=setup,
            window=roi,
            frames=frames,
            lens=lens,
            raw=raw,
            figure=figure,
            out=out,
        )
        analyse_balls(asked, as_json=json)
        return
    of_a_ball = {
        "--ball-mass-g": ball_mass_g,
        "--fps": fps,
        "--exposure-us": exposure_us,
        "--roi": roi,
        "--frames": frames,
        "--lens": lens,
        "--raw": raw,
        "--figure": figure,
    }
    refuse_options_of_a_ball(of_a_ball)
    _keep_sources(paths, out)
    options = _options(method, sigma_px, samples, matching, three=three)
    with Spool() as objects, ShotTable() as table:
        measured, refused = 0, ""

        def tell(number: int, shot: Shot) -> None:
            nonlocal measured, refused
            if isinstance(shot, MeasuredShot):
                measured += 1
            else:
                refused = refused or refusal(number, shot)
            if json:
                objects.add(shot_object(number, shot))
            else:
                table.add(number, shot)

        try:
            known = None if setup is None else read_description(setup)[1]
            # Loose files are numbered in the order given.
            campaign = joined([read_campaign(path, known) for path in paths])
            announce_compiling(method)
            started = time.perf_counter()
            read, rates = 0, set[float]()
            with _written(campaign, out, figures) as write:
                for job, shot, count in _watched(campaign, options, workers):
                    read += count
                    rates.add(job.setup.camera.frame_rate_hz)
                    tell(job.shot, shot)
                    write(job, shot, count)
            elapsed = time.perf_counter() - started
        except InputError as error:
            raise AnalysisInputError(error.reason, part=_place(error)) from error
        if json:
            head = {
                "campaign": campaign.name,
                "method": method,
                "frame_rate_hz": rates.pop() if len(rates) == 1 else None,
                "frames_per_second": round(read / elapsed, 1),
                "unlisted": [str(path) for path in campaign.unlisted],
            }
            print_document(head, "shots", objects)
        elif measured or len(campaign.jobs) > 1:
            table.print(campaign.name)
    _name_unlisted(campaign)
    if not measured:
        todo = OTHER_FILMS if setup is None and shows_something_else(campaign) else None
        raise nothing_measured(campaign.name, len(campaign.jobs), refused, todo)


def _name_unlisted(campaign: Campaign) -> None:
    if campaign.unlisted:
        names = ", ".join(map(str, campaign.unlisted))
        note = f"rigctl: frames without a row in {SHOT_LIST}, left out: {names}"
        print(note, file=sys.stderr)  # noqa: T201


def _require_places(out: Path | None, figures: Path | None, figure: Path | None) -> None:
    """Refuse places that nothing can be written to, before anything is measured."""
    for name, folder in (("--out", out), ("--figures", figures)):
        if folder is not None and folder.exists() and not folder.is_dir():
            raise SettingsError(
                "is a file; a folder is written", part=name, value=str(folder), todo="name another"
            )
    if figure is not None:
        _require_picture(figure)


def _require_picture(figure: Path) -> None:
    from matplotlib.backend_bases import FigureCanvasBase  # noqa: PLC0415 - it is slow to load

    kinds = sorted(f".{kind}" for kind in FigureCanvasBase.get_supported_filetypes())
    if figure.suffix.lower() not in kinds or figure.is_dir():
        raise SettingsError(
            "is no name of a picture",
            part="--figure",
            value=str(figure),
            limit=f"a file that ends in {', '.join(kinds)}",
        )


def _keep_sources(paths: Sequence[Path], out: Path | None) -> None:
    """Refuse to write an exchange folder over a campaign that is read."""
    read = {place.resolve() for path in paths for place in (path, path.parent.parent)}
    if out is not None and out.resolve() in read:
        raise AnalysisInputError(
            "is the campaign that is read; its files would be replaced",
            part=str(out),
            todo="choose another folder for --out",
        )


def _place(error: InputError) -> str:
    return error.path if error.line is None else f"{error.path}, line {error.line}"


def _options(
    method: Method,
    sigma_px: float | None,
    samples: int | None,
    matching: Matching | None,
    *,
    three: bool,
) -> AnalysisOptions:
    """Return the analysis's options; refuse those that the method does not have."""
    if method == "thesis":
        edges = EdgeSettings(samples_per_pixel=samples)
        if sigma_px is not None:
            edges = replace(edges, sigma_px=sigma_px)
        return AnalysisOptions(edges, matching, three, "thesis")
    given = {"--sigma-px": sigma_px, "--samples": samples, "--matching": matching}
    for name, value in given.items():
        if value is not None:
            raise AnalysisInputError(
                f"means nothing to the {method} method, which finds no edges",
                part=name,
                todo=f"leave {name} out, or add --method thesis",
            )
    return AnalysisOptions(three_and_three=three, method=method)


def _watched(campaign: Campaign, options: AnalysisOptions, workers: int | None) -> Iterator[Done]:
    """Give each shot as it is measured, with how many frames it had, under a progress bar."""
    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task("analysing", total=len(campaign.jobs))
        yield from analyse_campaign(
            campaign,
            options,
            workers,
            progress=lambda count, _: bar.update(task, completed=count),
        )


@contextmanager
def _written(
    campaign: Campaign, out: Path | None, figures: Path | None
) -> Iterator[Callable[[ShotJob, Shot, int], None]]:
    """Give a function that writes what is asked for of a shot with so many frames, and forgets it.

    No folder is made for a campaign of which no frames can be read.
    """
    with ExitStack() as opened:
        keep: Callable[[int, MeasuredShot], object] | None = None

        def write(job: ShotJob, shot: Shot, frames: int) -> None:
            nonlocal keep
            if out is not None and keep is None and frames > 0:
                keep = opened.enter_context(folder_writer(out, campaign.name, campaign.jobs))
            if not isinstance(shot, MeasuredShot):
                return
            if keep is not None:
                keep(job.shot, shot)
            if figures is not None:
                from analysis.figures.shot import draw_shot  # noqa: PLC0415 - loads matplotlib

                figures.mkdir(parents=True, exist_ok=True)
                path, title = figures / f"{job.shot:04d}.png", f"{campaign.name}, shot {job.shot}"
                draw_shot(path, title, read_frames(job.frames).pixels, shot)

        yield write
