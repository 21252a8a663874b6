"""`rigctl model explain`: the whole way, to a verdict."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from analysis.effects.effect import Effect
from analysis.effects.own.dropping import without_faulty
from analysis.model.data.stream import CampaignData
from analysis.model.design.between import Telling
from analysis.model.design.undecided import next_after
from analysis.model.fitting.nuisance_words import nuisance_lines
from analysis.model.verdict.report import verdict_document
from analysis.model.verdict.selection import Verdict, explain
from analysis.model.verdict.words import doubts, verdict_sentence
from rigctl.cli.model.reading import opened_in_parts, report_faults
from rigctl.cli.options import Campaign, Config, Json, OwnEffects, Pictures, Streamed
from rigctl.cli.output import TABLE_WIDTH, print_json, progress, unit_word
from rigctl.model.known_effects import available
from rigctl.temporary_room import temporary_room


def explaining(
    campaign: Campaign,
    *,
    folder: OwnEffects = None,
    out: Pictures = None,
    stream: Streamed = False,
    config: Config = None,
    json: Json = False,
) -> None:
    """Go the whole way by itself: which effect is missing, none, or none that is known.

    An effect of one's own with a fault is named and left out.

    Raises
    ------
    AnalysisInputError
        The campaign or the folder cannot be read.
    StoreError
        The temporary folder is full, or a picture cannot be written.
    """
    known = available(folder)
    title, data = opened_in_parts(campaign, config, stream=stream)
    with progress() as report, temporary_room():
        found, dropped = without_faulty(known.effects, lambda left: _verdict(data, left, report))
    verdict, following = found
    faults = report_faults([*known.faults, *dropped])
    document = {**verdict_document(title, data, verdict, following), "faults": faults}
    if json:
        print_json(document)
    else:
        _print(campaign, verdict, document)
    if out is not None:
        # Without pictures nothing waits for what draws them.
        from rigctl.cli.model.pictures import draw_explanation  # noqa: PLC0415

        draw_explanation(out, title, verdict)


def _print(campaign: Path, verdict: Verdict, document: dict[str, Any]) -> None:
    console = Console(width=TABLE_WIDTH)
    for sentence in (verdict_sentence(document), *doubts(document)):
        console.print(sentence, highlight=False)
    table = Table(title="error path", title_justify="left", box=None)
    for heading in ("with", "chi-squared per dof", "prediction error"):
        table.add_column(heading, justify="left" if heading == "with" else "right")
    for stage in document["path"]:
        name = ", ".join(stage["with"]) or "the base model"
        table.add_row(name, f"{stage['chi2_per_dof']:.4f}", f"{stage['prediction_error']:.4f}")
    table.caption = "prediction error: on shots left out, in units of the noise; 1 is the floor"
    console.print(table)
    for name, quantity in verdict.fit.parameters().items():
        value = f"{quantity.concise()} {unit_word(quantity.unit)}".rstrip()
        console.print(f"{name} = {value}", highlight=False)
    for line in nuisance_lines(document["nuisances"]):
        console.print(line, highlight=False)
    if document["next_shots"]:
        console.print(f"what to fire next: rigctl model next {campaign}", highlight=False)
    if document["rejected"]:
        console.print(f"shots rejected: {document['rejected']}", highlight=False)


def _verdict(
    data: CampaignData, effects: Sequence[Effect], report: Callable[[str], None]
) -> tuple[Verdict, Telling | None]:
    """Come to a verdict, and choose the shots that would end its doubts."""
    verdict = explain(data, effects, report)
    report("choosing shots")
    return verdict, next_after(verdict, effects)
