"""`rigctl qualify`: accuracy runs with a known truth."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rigctl.command_line.analysis import Method
from rigctl.command_line.options import Json

if TYPE_CHECKING:
    from rigctl.commands.analysis.qualify import Request

qualify = typer.Typer(help="The accuracy runs of the thesis on simulated apparatus, truth beside.")

By = Annotated[
    Method | None, typer.Option("--method", help="How images are measured; without it all ways.")
]
ByEdges = Annotated[Method, typer.Option("--method", help="How images are measured.")]
Seed = Annotated[int, typer.Option(min=0, help="Of the simulated apparatus and its noise.")]
Out = Annotated[
    Path | None, typer.Option("--out", help="Write the figure (PNG and SVG) into this folder.")
]


@qualify.command("stage")
def qualify_stage(
    *, method: By = None, seed: Seed = 0, out: Out = None, json: Json = False
) -> None:
    """Move a sphere in quarters of a pixel (figures 4.1 and 4.2)."""
    from rigctl.commands.analysis.qualify import stage

    stage(_request(method, seed, out, as_json=json))


@qualify.command("drop")
def qualify_drop(*, method: By = None, seed: Seed = 0, out: Out = None, json: Json = False) -> None:
    """Take gravity from ten falls of a sphere (table 6.1)."""
    from rigctl.commands.analysis.qualify import drop

    drop(_request(method, seed, out, as_json=json))


@qualify.command("disk")
def qualify_disk(*, method: By = None, seed: Seed = 0, out: Out = None, json: Json = False) -> None:
    """Measure angles of a disk that turns at 997 turns a minute (table 6.2)."""
    from rigctl.commands.analysis.qualify import disk

    disk(_request(method, seed, out, as_json=json))


@qualify.command("depth")
def qualify_depth(
    *, method: ByEdges = Method.THESIS, seed: Seed = 0, out: Out = None, json: Json = False
) -> None:
    """Measure shots with the mirror and with Z constant (table 3.3)."""
    from rigctl.commands.analysis.qualify import depth

    depth(_request(method, seed, out, as_json=json))


def _request(method: Method | None, seed: int, out: Path | None, *, as_json: bool) -> Request:
    from rigctl.commands.analysis.qualify import Request

    return Request(None if method is None else method.value, seed, out, as_json)
