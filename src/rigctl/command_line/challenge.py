"""`rigctl challenge`: a hidden effect, an answer, the truth."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from rigctl.command_line.options import Json

challenge = typer.Typer(help="A campaign that hides an effect, your answer, and the truth.")

SHOTS, FILMED_SHOTS = 120, 30
"""How many without further word: poses, frames."""

Folder = Annotated[Path, typer.Argument(help="Folder of the challenge.")]


class Strength(StrEnum):
    """How strong what is hidden is."""

    FULL = "full"
    QUARTER = "quarter"


@challenge.command("new")
def challenge_new(
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
    """Write a campaign that hides an effect, or two, or none."""
    from rigctl.commands.challenge import new

    if shots is None:
        shots = FILMED_SHOTS if from_frames else SHOTS
    new(folder, seed=seed, strength=strength.value, shots=shots, from_frames=from_frames)
    typer.echo(f"{folder}: {shots} shots; answer with rigctl challenge commit {folder}")


@challenge.command("commit")
def challenge_commit(
    folder: Folder,
    *,
    answer: Annotated[
        str, typer.Option(help="Names of effects, separated by commas; or none, or unexplained.")
    ],
) -> None:
    """Set down your answer, once and for all."""
    from analysis.effects.catalogue import CATALOGUE
    from rigctl.commands.challenge import commit

    names = commit(folder, answer, known=[effect.name for effect in CATALOGUE])
    typer.echo(f"{folder}: {', '.join(names)}; see the truth with rigctl challenge reveal {folder}")


@challenge.command("reveal")
def challenge_reveal(folder: Folder, *, json: Json = False) -> None:
    """Say what was hidden, and how your answer stands to it."""
    from rigctl.commands.challenge import reveal, summary

    typer.echo(summary(*reveal(folder), as_json=json))
