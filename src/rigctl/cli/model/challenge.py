"""`rigctl challenge`: a campaign that hides an effect, the user's answer, and the truth."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from analysis.effects.catalogue import CATALOGUE
from rigctl import challenge
from rigctl.cli.options import Json
from rigctl.model.answered_law import known_law

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
