"""What `rigctl demo` tells: shots beside their truth, the falling error, and what was hidden."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from analysis.model.verdict.words import verdict_sentence
from analysis.quantity import Quantity
from analysis.schema.verdict import VerdictReport
from rigctl.challenge import reveal, summary
from rigctl.documents import Json

WIDTH = 100
"""A narrower terminal wraps the rows; cut digits would be wrong numbers."""
CANDIDATES = 3
MEASURED = (("v_n", "m/s"), ("v_s", "m/s"), ("e", ""), ("beta", ""))


@dataclass(frozen=True, slots=True)
class Story:
    """A demonstration from its first shot to the truth.

    Attributes
    ----------
    records
        Shots as the service shows them, each with its result.
    verdict
        What was concluded, before anything of the truth was seen.
    answer
        Names that were committed to.
    truth
        Folder with truth.jsonl, the sealed label and the answer.
    """

    records: Sequence[Json]
    verdict: VerdictReport
    answer: Sequence[str]
    truth: Path


def print_story(story: Story, pictures: Sequence[Path], folder: Path) -> None:
    """Print the whole story; the truth comes last, and only to a verdict that was committed."""
    console = Console(width=WIDTH, highlight=False)
    console.print(_shots(story))
    console.print()
    console.print(_ranking(story.verdict))
    console.print()
    console.print(_path(story.verdict))
    console.print()
    console.print(verdict_sentence(story.verdict))
    console.print(_committed(story))
    console.print(summary(*reveal(story.truth), as_json=False))
    console.print(f"Pictures: {', '.join(map(str, pictures))}", soft_wrap=True)
    console.print(f"Frames, manifests and results: {folder}", soft_wrap=True)


def _committed(story: Story) -> str:
    """Say what was answered, and what to think of an error that did not reach its floor."""
    said = f"Committed: {', '.join(story.answer)}."
    if not story.verdict.unexplained:
        return said
    return (
        f"{said} Errors of the images that differ from shot to shot, but hardly from frame to "
        "frame, count as structure too: the last tenths above the floor are no reason to add an "
        "effect."
    )


def _shots(story: Story) -> Table:
    """Return measured speeds and coefficients, the simulator's beside the coefficients."""
    table = Table(title="Fire and measure", title_justify="left", box=None)
    headings = ("kPa", "mm", *(f"{name} {unit}".strip() for name, unit in MEASURED))
    for heading in (*headings, "true e", "true beta"):
        table.add_column(heading, justify="right", no_wrap=True)
    truths = _truths(story.truth)
    for number, record in enumerate(story.records, start=1):
        settings, result = record["settings"], record["result"] or {}
        cells = [_cell(result.get(name)) for name, _ in MEASURED]
        cells += _coefficients(truths.get(number, {}))
        table.add_row(f"{settings['pressure_a_kpa']:g}", f"{settings['offset_mm']:g}", *cells)
    table.caption = "in brackets: standard error in units of the last digit"
    return table


def _truths(folder: Path) -> dict[int, Json]:
    lines = (folder / "truth.jsonl").read_text(encoding="utf-8").splitlines()
    return {int(truth["shot"]): truth for truth in map(json.loads, lines)}


def _coefficients(truth: Json) -> list[str]:
    if truth.get("missed", True):
        return ["-", "-"]
    e, beta = -truth["v_n_after"] / truth["v_n"], -truth["v_s_after"] / truth["v_s"]
    return [f"{e:.4f}", f"{beta:.4f}"]


def _cell(quantity: Mapping[str, Any] | None) -> str:
    if quantity is None:
        return "-"
    return Quantity.from_json(quantity).concise()


def _ranking(verdict: VerdictReport) -> Table:
    table = Table(title="Compare and find", title_justify="left", box=None)
    for heading in ("candidate", "score", "chance", "amplitude", "unit"):
        table.add_column(heading, justify="left" if heading in {"candidate", "unit"} else "right")
    for candidate in verdict.candidates[:CANDIDATES]:
        amplitude = Quantity(candidate.amplitude, candidate.sigma, candidate.unit)
        table.add_row(
            candidate.effect,
            f"{candidate.score:.1f}",
            f"{candidate.p_familywise:.1g}",
            amplitude.concise(),
            candidate.unit,
        )
    table.caption = (
        "effects that are not in the fit, the largest expected drop of chi-squared first"
    )
    return table


def _path(verdict: VerdictReport) -> Table:
    table = Table(title="Add, and see the error fall", title_justify="left", box=None)
    for heading in ("with", "chi-squared per dof", "error on shots left out"):
        table.add_column(heading, justify="left" if heading == "with" else "right")
    for stage in verdict.path:
        name = ", ".join(stage.effects) or "the base model"
        table.add_row(name, f"{stage.chi2_per_dof:.3f}", f"{stage.prediction_error:.3f}")
    table.caption = "errors in units of the noise; 1 is the floor"
    if names := taken_out([stage.effects for stage in verdict.path]):
        table.caption += (
            f"\n{', '.join(names)}: added when it lowered the error most by itself, then taken out "
            "again, as the model does as well without it"
        )
    return table


def taken_out(stages: Sequence[Sequence[str]]) -> list[str]:
    """Return the effects that the way to a verdict added and dropped again, in their order."""
    added = dict.fromkeys(effect for effects in stages for effect in effects)
    return [effect for effect in added if effect not in stages[-1]]
