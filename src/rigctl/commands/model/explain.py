"""`rigctl model explain`: the whole way, to a verdict."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from analysis.effects.effect import Effect
from analysis.effects.own.dropping import without_faulty
from analysis.model.data.tables import Data
from analysis.model.design.between import Telling
from analysis.model.design.undecided import next_after
from analysis.model.verdict.report import verdict_document
from analysis.model.verdict.selection import Verdict, explain
from analysis.model.verdict.words import doubts, verdict_sentence
from rigctl.commands import report
from rigctl.commands.effect import tell
from rigctl.commands.model.printing import TABLE_WIDTH, print_json
from rigctl.commands.model.reading import opened
from rigctl.model.known_effects import available


def explaining(
    campaign: Path,
    *,
    as_json: bool,
    folder: Path | None = None,
    configuration: Path | None = None,
) -> tuple[str, Verdict]:
    """Go the whole way by itself: which effect is missing, none, or none that is known.

    Parameters
    ----------
    folder
        Where the user's own effects are. One with a fault is named and left out.
    configuration
        Of the rig whose store holds a campaign that is named; None: the simulated rig's.

    Returns
    -------
    The campaign's name, and the verdict.

    Raises
    ------
    AnalysisInputError
        The campaign or the folder cannot be read.
    """
    known = available(folder)
    title, data = opened(campaign, configuration)
    with report.progress() as say:
        found, dropped = without_faulty(known.effects, lambda left: _judged(data, left, say))
    verdict, following = found
    faults = tell([*known.faults, *dropped])
    document = {**verdict_document(title, data, verdict, following), "faults": faults}
    if as_json:
        print_json(document)
        return title, verdict
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
        unit = "" if quantity.unit == "1" else f" {quantity.unit}"
        console.print(f"{name} = {quantity.concise()}{unit}", highlight=False)
    if document["next_shots"]:
        console.print(f"what to fire next: rigctl model next {campaign}", highlight=False)
    if document["rejected"]:
        console.print(f"shots rejected: {document['rejected']}", highlight=False)
    return title, verdict


def _judged(
    data: Data, effects: Sequence[Effect], say: Callable[[str], None]
) -> tuple[Verdict, Telling | None]:
    """Come to a verdict, and choose the shots that would end its doubts."""
    verdict = explain(data, effects, say)
    say("choosing shots")
    return verdict, next_after(verdict, effects)
