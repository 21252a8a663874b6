"""`rigctl qualify`: the accuracy runs of the thesis, its values beside ours."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Annotated, TypeVar, get_args

import typer
from matplotlib.figure import Figure
from rich.console import Console
from rich.progress import track

from analysis.errors import ShotRefusedError
from analysis.qualification.depth import BothWays, measure_both_ways
from analysis.qualification.disk import Turn, measure_disk
from analysis.qualification.drop import Gravity, Method, gravity, measure_fall
from analysis.qualification.figures import depth_figure, disk_figure, drop_figure, stage_figure
from analysis.qualification.locating import WAYS, Way
from analysis.qualification.stage import StageErrors, measure_stage
from rigctl.cli.figures import write_figures
from rigctl.cli.frames.qualify_apparatus import apparatus, setup_of
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

Item = TypeVar("Item")


By = Annotated[
    Method | None, typer.Option("--method", help="How images are measured; without it all ways.")
]
Seed = Annotated[int, typer.Option(min=0, help="Of the simulated apparatus and its noise.")]
Out = Annotated[
    Path | None, typer.Option("--out", help="Write the figure (PNG and SVG) into this folder.")
]


def stage(*, method: By = None, seed: Seed = 0, out: Out = None, json: Json = False) -> None:
    """Move a sphere in quarters of a pixel and find its centre in every way.

    Raises
    ------
    AnalysisInputError
        The frames cannot be measured; so in the runs below.
    StoreError
        The picture cannot be written; so in the runs below.
    """
    results: list[StageErrors] = []
    for direction in _watched(DIRECTIONS, "stage"):
        run = apparatus().stage_run(direction, seed)
        ways = STAGE_WAYS[method]
        results += _measured("stage", partial(measure_stage, run.frames, run.moved_px, ways))
    _show("stage", seed, (stage_document(results), stage_lines(results)), as_json=json)
    _draw("stage", out, lambda: stage_figure(results))


def drop(*, method: By = None, seed: Seed = 0, out: Out = None, json: Json = False) -> None:
    """Let a sphere fall ten times and take gravity from its path."""
    drops = [apparatus().filmed_drop(DROPS * seed + k) for k in range(DROPS)]
    found: dict[Method, Gravity] = {}
    for way in METHODS if method is None else (method,):
        falls = [
            _measured("drop", partial(measure_fall, one.frames, one.times_s, way))
            for one in _watched(drops, f"drop, {way}")
        ]
        found[way] = gravity(falls, drops[0].diameter_m, drops[0].gravity_m_per_s2)
    _show("drop", seed, (drop_document(found), drop_lines(found)), as_json=json)
    _draw("drop", out, lambda: drop_figure(found))


def disk(*, method: By = None, seed: Seed = 0, out: Out = None, json: Json = False) -> None:
    """Turn a disk at 997 turns a minute and measure its angles."""
    run = apparatus().turning_disk(seed)
    found: dict[Method, list[Turn]] = {}
    for way in _watched(METHODS if method is None else (method,), "disk"):
        found[way] = _measured("disk", partial(measure_disk, run.frames, run.turn_rad, way))
    _show("disk", seed, (disk_document(found), disk_lines(found)), as_json=json)
    _draw("disk", out, lambda: disk_figure(found))


def depth(
    *,
    method: MeasuredBy = "thesis",
    seed: Seed = 0,
    out: Out = None,
    json: Json = False,
) -> None:
    """Measure shots with the mirror and without; by edges unless another method is asked for."""
    shots: list[BothWays] = []
    refused: list[str] = []
    for number in _watched(range(SHOTS), "depth"):
        filmed = apparatus().filmed_shot(number, seed)
        both = measure_both_ways(filmed.frames, filmed.times_s, setup_of(filmed), method)
        if isinstance(both, BothWays):
            shots.append(both)
        else:
            refused.append(f"shot {number + 1} refused at {both.step}: {both.reason}")
    if not shots:
        raise AnalysisInputError("; ".join(refused), part="qualify depth")
    document = depth_document(method, shots, refused)
    _show("depth", seed, (document, depth_lines(method, shots, refused)), as_json=json)
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


def _show(run: str, seed: int, result: tuple[Document, Lines], *, as_json: bool) -> None:
    document, lines = result
    if as_json:
        print_json({"run": run, "seed": seed, **document})
    else:
        print_lines(lines)


def _draw(run: str, folder: Path | None, figure: Callable[[], Figure]) -> None:
    if folder is not None:
        write_figures(folder, [(run, figure())])
