"""`rigctl qualify`: the accuracy runs of the thesis, its values beside ours."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TypeVar, get_args

from matplotlib.figure import Figure
from rich.console import Console
from rich.progress import track

from analysis.errors import ShotRefusedError
from analysis.figures.sheet import write
from analysis.qualification.depth import BothWays, measure_both_ways
from analysis.qualification.disk import Turn, measure_disk
from analysis.qualification.drop import Gravity, Method, gravity, measure_fall
from analysis.qualification.figures import depth_figure, disk_figure, drop_figure, stage_figure
from analysis.qualification.locating import WAYS, Way
from analysis.qualification.stage import StageErrors, measure_stage
from rigctl.commands.analysis.qualify_apparatus import apparatus, setup_of
from rigctl.commands.analysis.qualify_tables import (
    Json,
    Lines,
    depth_document,
    depth_lines,
    disk_document,
    disk_lines,
    drop_document,
    drop_lines,
    print_run,
    stage_document,
    stage_lines,
)
from rigctl.errors import AnalysisInputError, StoreError

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


@dataclass(frozen=True, slots=True)
class Request:
    """What every run takes.

    Attributes
    ----------
    method
        None: all that apply.
    seed
        Of the simulated apparatus.
    out
        Folder for the picture, PNG and SVG.
    as_json
        Print one JSON document instead of a table.
    """

    method: Method | None
    seed: int
    out: Path | None
    as_json: bool

    @property
    def methods(self) -> tuple[Method, ...]:
        """Methods to run."""
        return METHODS if self.method is None else (self.method,)


def stage(request: Request) -> None:
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
        run = apparatus().stage_run(direction, request.seed)
        ways = STAGE_WAYS[request.method]
        results += _measured("stage", partial(measure_stage, run.frames, run.moved_px, ways))
    _show(request, "stage", (stage_document(results), stage_lines(results)))
    _draw(request, "stage", lambda: stage_figure(results))


def drop(request: Request) -> None:
    """Let a sphere fall ten times and take gravity from its path."""
    drops = [apparatus().filmed_drop(DROPS * request.seed + k) for k in range(DROPS)]
    found: dict[Method, Gravity] = {}
    for method in request.methods:
        falls = [
            _measured("drop", partial(measure_fall, one.frames, one.times_s, method))
            for one in _watched(drops, f"drop, {method}")
        ]
        found[method] = gravity(falls, drops[0].diameter_m, drops[0].gravity_m_per_s2)
    _show(request, "drop", (drop_document(found), drop_lines(found)))
    _draw(request, "drop", lambda: drop_figure(found))


def disk(request: Request) -> None:
    """Turn a disk at 997 turns a minute and measure its angles."""
    run = apparatus().turning_disk(request.seed)
    found: dict[Method, list[Turn]] = {}
    for method in _watched(request.methods, "disk"):
        found[method] = _measured("disk", partial(measure_disk, run.frames, run.turn_rad, method))
    _show(request, "disk", (disk_document(found), disk_lines(found)))
    _draw(request, "disk", lambda: disk_figure(found))


def depth(request: Request) -> None:
    """Measure shots with the mirror and without; by edges unless another method is asked for."""
    method: Method = request.method or "thesis"
    shots: list[BothWays] = []
    refused: list[str] = []
    for number in _watched(range(SHOTS), "depth"):
        filmed = apparatus().filmed_shot(number, request.seed)
        both = measure_both_ways(filmed.frames, filmed.times_s, setup_of(filmed), method)
        if isinstance(both, BothWays):
            shots.append(both)
        else:
            refused.append(f"shot {number + 1} refused at {both.step}: {both.reason}")
    if not shots:
        raise AnalysisInputError("; ".join(refused), part="qualify depth")
    document = depth_document(method, shots, refused)
    _show(request, "depth", (document, depth_lines(method, shots, refused)))
    _draw(request, "depth", lambda: depth_figure({method: shots}))


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


def _show(request: Request, run: str, result: tuple[Json, Lines]) -> None:
    document, lines = result
    print_run({"run": run, "seed": request.seed, **document}, lines, as_json=request.as_json)


def _draw(request: Request, run: str, figure: Callable[[], Figure]) -> None:
    if request.out is None:
        return
    try:
        paths = write(figure(), request.out, run)
    except OSError as error:
        raise StoreError(
            f"a picture cannot be written: {error.strerror or error}",
            part=str(error.filename or request.out),
            todo="free the disk or choose another folder with --out",
        ) from error
    note = "rigctl: wrote " + ", ".join(map(str, paths))
    print(note, file=sys.stderr)  # noqa: T201
