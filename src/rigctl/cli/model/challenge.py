"""`rigctl challenge`: a campaign that hides an effect, the user's answer, and the truth."""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum
from pathlib import Path
from typing import Annotated, get_args

import typer

from analysis.effects.catalogue import CATALOGUE
from analysis.exchange.shot_list import read_shot_list
from analysis.model.proposals.arguments import OF_PLACES, OF_SPINS, ON_BODIES, ORDER, SPEEDS
from analysis.model.proposals.channels import InFrames
from analysis.model.proposals.forms.flight import flight_forms
from analysis.model.proposals.forms.frame import frame_forms
from analysis.model.proposals.forms.shapes import SHAPES
from analysis.model.proposals.stated import Slot
from rigctl import challenge
from rigctl.challenge import Law
from rigctl.cli.options import Json
from rigctl.errors import SettingsError
from rigctl.input_errors import as_analysis_errors

SHOT_LIST = "shots.csv"
_ANY_RADIUS_M, _ANY_MASS_KG = 0.0125, 0.01
"""Names of forms do not depend on the spheres."""


def known_law(folder: Path, law: Law) -> Law:
    """Return a law whose names are all known, the arguments of a product in alphabetical order.

    Parameters
    ----------
    folder
        Of the challenge: a law may follow the numeric columns of its shot list.

    Raises
    ------
    SettingsError
        A slot, an argument or a shape has no such name.
    AnalysisInputError
        The shot list cannot be read.
    """
    slot, argument, shape = law
    in_frames: list[InFrames] = [*flight_forms(_ANY_RADIUS_M, _ANY_MASS_KG), *frame_forms()]
    _require("slot", slot, get_args(Slot))
    arguments = {a.name for a in (*SPEEDS, *OF_SPINS, *OF_PLACES, *ON_BODIES)} | {ORDER}
    arguments |= {form.argument for form in in_frames} | _columns(folder)
    parts = sorted(argument.split("*"))
    for part in parts:
        _require("argument", part, arguments)
    _require("shape", shape, {s.name for s in SHAPES} | {f.shape_name for f in in_frames})
    return slot, "*".join(parts), shape


def _require(what: str, name: str, known: Iterable[str]) -> None:
    if name not in known:
        raise SettingsError(
            f"no {what} of a law has this name",
            part="--law",
            value=repr(name),
            todo=f"choose one of {', '.join(sorted(known))}",
        )


def _columns(folder: Path) -> set[str]:
    """Return the numeric columns of a challenge's shot list; none where there is no list."""
    path = folder / SHOT_LIST
    if not path.is_file():
        return set()
    with as_analysis_errors("restore the challenge's folder, or make the challenge again"):
        return {name for row in read_shot_list(path) for name in row.numbers}


SHOTS, FILMED_SHOTS = 120, 30
"""How many without further word: poses, frames."""

Folder = Annotated[Path, typer.Argument(help="Folder of the challenge.")]


class Strength(StrEnum):
    """How strong what is hidden is."""

    FULL = "full"
    QUARTER = "quarter"


def new(
    folder: Folder,
    *,
    seed: Annotated[
        int | None, typer.Option(min=0, help="Gives the same folder again; without it by chance.")
    ] = None,
    strength: Annotated[
        Strength, typer.Option(help="Of what is hidden: as a rig would have it, or a quarter.")
    ] = Strength.FULL,
    shots: Annotated[
        int | None,
        typer.Option(min=3, max=10_000, help="Number; without it 120, or 30 from frames."),
    ] = None,
    from_frames: Annotated[
        bool, typer.Option("--from-frames", help="Frames in the place of poses.")
    ] = False,
) -> None:
    """Make a challenge; raise as `rigctl.challenge.new`, and so below."""
    if shots is None:
        shots = FILMED_SHOTS if from_frames else SHOTS
    challenge.new(folder, seed=seed, strength=strength.value, shots=shots, from_frames=from_frames)
    typer.echo(f"{folder}: {shots} shots; answer with rigctl challenge commit {folder}")


def commit(
    folder: Folder,
    *,
    answer: Annotated[
        str, typer.Option(help="Names of effects, separated by commas; or none, or unexplained.")
    ],
    law: Annotated[
        tuple[str, str, str] | None,
        typer.Option(help="Slot, argument and shape of the law, beside unexplained."),
    ] = None,
) -> None:
    """Keep an answer of known names."""
    stated = None if law is None else known_law(folder, law)
    known = [effect.name for effect in CATALOGUE]
    names = challenge.commit(folder, answer, known=known, law=stated)
    typer.echo(f"{folder}: {', '.join(names)}; see the truth with rigctl challenge reveal {folder}")


def reveal(folder: Folder, *, json: Json = False) -> None:
    """Print the truth beside the answer."""
    label, answer, outcome = challenge.reveal(folder)
    law = challenge.law_compared(folder, label)
    typer.echo(challenge.summary(label, answer, outcome, as_json=json, law=law))
