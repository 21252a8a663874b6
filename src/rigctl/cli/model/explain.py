"""`rigctl model explain`: the whole way, to a verdict."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console
from rich.table import Table

from analysis.effects.own.dropping import without_faulty
from analysis.model.design.undecided import explain_with_next
from analysis.model.fitting.nuisance_words import nuisance_lines
from analysis.model.verdict.documents import verdict_report
from analysis.model.verdict.words import doubts, verdict_sentence
from analysis.schema.codec import written
from analysis.schema.verdict import VerdictReport
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
        (verdict, following), dropped = without_faulty(
            known.effects, lambda left: explain_with_next(data, left, report)
        )
    faults = report_faults([*known.faults, *dropped])
    found = verdict_report(title, data, verdict, following)
    if json:
        print_json({**written(found), "faults": faults})
    else:
        _print(campaign, found)
    if out is not None:
        # Without pictures nothing waits for what draws them.
        from rigctl.cli.model.pictures import draw_explanation  # noqa: PLC0415

        draw_explanation(out, title, verdict)


def _print(campaign: Path, found: VerdictReport) -> None:
    console = Console(width=TABLE_WIDTH)
    for sentence in (verdict_sentence(found), *doubts(found)):
        console.print(sentence, highlight=False)
    table = Table(title="error path", title_justify="left", box=None)
    for heading in ("with", "chi-squared per dof", "prediction error"):
        table.add_column(heading, justify="left" if heading == "with" else "right")
    for stage in found.path:
        name = ", ".join(stage.effects) or "the base model"
        table.add_row(name, f"{stage.chi2_per_dof:.4f}", f"{stage.prediction_error:.4f}")
    table.caption = "prediction error: on shots left out, in units of the noise; 1 is the floor"
    console.print(table)
    for name, quantity in found.parameters.items():
        value = f"{quantity.concise()} {unit_word(quantity.unit)}".rstrip()
        console.print(f"{name} = {value}", highlight=False)
    for line in nuisance_lines(found.nuisances):
        console.print(line, highlight=False)
    if found.next_shots:
        console.print(f"what to fire next: rigctl model next {campaign}", highlight=False)
    if found.rejected:
        console.print(f"shots rejected: {list(found.rejected)}", highlight=False)
