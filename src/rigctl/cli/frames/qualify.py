"""`rigctl qualify`: the accuracy runs of the thesis, its values beside ours."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Annotated, Literal, TypeVar, get_args

import typer
from matplotlib.figure import Figure
from rich.console import Console
from rich.progress import track

from analysis.errors import ShotRefusedError
from analysis.qualification.depth import BothWays, measure_both_ways
from analysis.qualification.disk import Turn, measure_disk
from analysis.qualification.drop import Gravity, Method, gravity, measure_fall
from analysis.qualification.figures import depth_figure, disk_figure, drop_figure, stage_figure
from analysis.qualification.good_for import Verdict, of_depth, of_disk, of_drop, of_stage
from analysis.qualification.locating import WAYS, Way
from analysis.qualification.stage import StageErrors, measure_stage
from rigctl.cli.figures import write_figures
from rigctl.cli.frames import qualify_sources as sources
from rigctl.cli.frames.qualify_sources import FALLS_OF_A_RIG, Source, chosen_source
from rigctl.cli.frames.qualify_tables import (
    Document,
    Lines,
    depth_document,
    depth_lines,
    disk_document,
    disk_lines,
    drop_document,
    drop_lines,
    print_lines,
    stage_document,
    stage_lines,
)
from rigctl.cli.options import Json, MeasuredBy
from rigctl.cli.output import print_json
from rigctl.errors import AnalysisInputError

METHODS: tuple[Method, ...] = get_args(Method)
DIRECTIONS = ((0.0, 1.0), (1.0, 0.0), (1.0, 1.0))
"""Figures 4.1a, b, c: along the columns, along the rows, both."""
STAGE_WAYS: Mapping[Method | None, tuple[Way, ...]] = {
    None: WAYS,
    "thesis": tuple(way for way in WAYS if way != "photometric"),
    "photometric": ("photometric",),
}
DROPS, SHOTS = 10, 6
STANDARD_GRAVITY = 9.80665

Item = TypeVar("Item")


By = Annotated[
    Method | None, typer.Option("--method", help="How images are measured; without it all ways.")
]
Seed = Annotated[int, typer.Option(min=0, help="Of the simulated apparatus and its noise.")]
FramesOf = Annotated[
    list[Path] | None,
    typer.Option("--frames", help="Frames of your own apparatus; may be given several times."),
]
Of = Annotated[
    Path | None,
    typer.Option("--config", help="Configuration whose own parts record the frames (TOML)."),
]
Rate = Annotated[
    float | None,
    typer.Option("--fps", min=0.001, help="With --frames: frames a second, where no file says."),
]
Along = Literal["x", "y", "x-y"]
Out = Annotated[
    Path | None, typer.Option("--out", help="Write the figure (PNG and SVG) into this folder.")
]


def stage(
    *,
    method: By = None,
    seed: Seed = 0,
    frames: FramesOf = None,
    step_px: Annotated[
        float | None, typer.Option(min=0.0, help="With --frames: way of each step, pixels.")
    ] = None,
    direction: Annotated[
        Along, typer.Option(help="With --frames: along the columns (x), the rows (y), or both.")
    ] = "x",
    config: Of = None,
    out: Out = None,
    json: Json = False,
) -> None:
    """Move a sphere in quarters of a pixel and find its centre in every way.

    Raises
    ------
    AnalysisInputError
        The frames cannot be measured; so in the runs below.
    SettingsError
        Options that do not go together, or what frames need is not stated; so in the runs below.
    RigError
        A part of one's own apparatus did not do its work; so in the runs below.
    StoreError
        The picture cannot be written; so in the runs below.
    """
    source = chosen_source(frames, config, {"--step-px": step_px})
    runs = sources.stages(source, direction, seed, DIRECTIONS)
    ways, results = STAGE_WAYS[method], list[StageErrors]()
    for run in _watched(runs, "stage"):
        results += _measured("stage", partial(measure_stage, run.frames, run.moved_px, ways))
    shown = (stage_document(results), stage_lines(results), of_stage(results))
    _show("stage", source, seed, shown, as_json=json)
    _draw("stage", out, lambda: stage_figure(results))


def drop(
    *,
    method: By = None,
    seed: Seed = 0,
    frames: FramesOf = None,
    ball_diameter_mm: Annotated[
        float | None, typer.Option(min=0.001, help="With --frames: the sphere's diameter, mm.")
    ] = None,
    gravity_m_per_s2: Annotated[
        float, typer.Option(min=0.01, help="With --frames: gravity at the place.")
    ] = STANDARD_GRAVITY,
    fps: Rate = None,
    config: Of = None,
    drops: Annotated[
        int, typer.Option(min=1, max=1000, help="With --config: how many falls.")
    ] = FALLS_OF_A_RIG,
    out: Out = None,
    json: Json = False,
) -> None:
    """Let a sphere fall ten times and take gravity from its path."""
    source = chosen_source(frames, config, {"--ball-diameter-mm": ball_diameter_mm})
    stated = sources.Falling(gravity_m_per_s2, fps, drops, DROPS)
    runs = _measured("drop", lambda: sources.falls(source, stated, seed))
    found: dict[Method, Gravity] = {}
    for way in METHODS if method is None else (method,):
        falls = [
            _measured("drop", partial(measure_fall, one.frames, one.times_s, way))
            for one in _watched(runs, f"drop, {way}")
        ]
        found[way] = gravity(falls, runs[0].diameter_m, runs[0].gravity_m_per_s2)
    best = found.get("photometric") or next(iter(found.values()))
    _show(
        "drop",
        source,
        seed,
        (drop_document(found), drop_lines(found), of_drop(best, [*found.values()])),
        as_json=json,
    )
    _draw("drop", out, lambda: drop_figure(found))


def disk(
    *,
    method: By = None,
    seed: Seed = 0,
    frames: FramesOf = None,
    rpm: Annotated[
        float | None, typer.Option(min=0.001, help="With --frames: turns of the disk a minute.")
    ] = None,
    fps: Rate = None,
    config: Of = None,
    out: Out = None,
    json: Json = False,
) -> None:
    """Turn a disk at 997 turns a minute and measure its angles."""
    source = chosen_source(frames, config, {"--rpm": rpm})
    run, rate_hz = sources.disk(source, fps, seed)
    found: dict[Method, list[Turn]] = {}
    for way in _watched(METHODS if method is None else (method,), "disk"):
        found[way] = _measured("disk", partial(measure_disk, run.frames, run.turn_rad, way))
    best = found.get("photometric") or next(iter(found.values()))
    shown = (disk_document(found), disk_lines(found), of_disk(best, rate_hz))
    _show("disk", source, seed, shown, as_json=json)
    _draw("disk", out, lambda: disk_figure(found))


def depth(
    *,
    method: MeasuredBy = "thesis",
    seed: Seed = 0,
    frames: FramesOf = None,
    out: Out = None,
    json: Json = False,
) -> None:
    """Measure shots with the mirror and without; by edges unless another method is asked for."""
    source = chosen_source(frames, None, {})
    shots: list[BothWays] = []
    refused: list[str] = []
    runs = sources.shots(source, seed, SHOTS)
    for number, shot in enumerate(_watched(runs, "depth"), start=1):
        both = measure_both_ways(shot.frames, shot.times_s, shot.setup, method)
        if isinstance(both, BothWays):
            shots.append(both)
        else:
            refused.append(f"shot {number} refused at {both.step}: {both.reason}")
    if not shots:
        raise AnalysisInputError("; ".join(refused), part="qualify depth")
    document = depth_document(method, shots, refused)
    shown = (document, depth_lines(method, shots, refused), of_depth(shots))
    _show("depth", source, seed, shown, as_json=json)
    _draw("depth", out, lambda: depth_figure({method: shots}))


def _watched(items: Iterable[Item], what: str) -> Iterator[Item]:
    """Yield items under a progress bar when a person watches."""
    every = list(items)
    console = Console(stderr=True)
    yield from track(every, what, console=console, transient=True, disable=not sys.stderr.isatty())


def _measured(run: str, measure: Callable[[], Item]) -> Item:
    try:
        return measure()
    except ShotRefusedError as refusal:
        raise AnalysisInputError(str(refusal), part=f"qualify {run}") from refusal


def _show(
    run: str,
    source: Source,
    seed: int,
    result: tuple[Document, Lines, Verdict],
    *,
    as_json: bool,
) -> None:
    document, lines, verdict = result
    if as_json:
        good_for = {"sentence": verdict.sentence, **verdict.numbers}
        origin = {"seed": seed} if source.simulated else {"of": source.name}
        print_json({"run": run, **origin, **document, "good_for": good_for})
        return
    print_lines(lines)
    typer.echo(("" if source.simulated else f"{source.name}: ") + verdict.sentence)


def _draw(run: str, folder: Path | None, figure: Callable[[], Figure]) -> None:
    if folder is not None:
        write_figures(folder, [(run, figure())])
