"""`rigctl model rank`: the score of every effect that is not in the fit."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table

from analysis.effects.own.dropping import without_faulty
from analysis.effects.own.fault import EffectFault
from analysis.model.rank.candidate import Candidate, Ranking
from analysis.model.verdict.documents import SHOWN_ALIAS, alike, fit_document, ranking_document
from analysis.quantity import Quantity
from rigctl.cli.model.reading import fitted, report_faults
from rigctl.cli.options import Campaign, Config, Json, OwnEffects, Pictures, Streamed, With
from rigctl.cli.output import TABLE_WIDTH, print_json, unit_word
from rigctl.model.headline import headline
from rigctl.model.known_effects import available, refused


def ranking(
    campaign: Campaign,
    *,
    effects: With = None,
    folder: OwnEffects = None,
    out: Pictures = None,
    stream: Streamed = False,
    config: Config = None,
    json: Json = False,
) -> None:
    """Fit the base model and the named effects, and rank what else the data ask for.

    An effect of one's own with a fault is named and left out.

    Raises
    ------
    AnalysisInputError
        The campaign or the folder cannot be read, or a named effect has a fault.
    NotFoundError
        No effect has that name.
    StoreError
        The temporary folder is full, or a picture cannot be written.
    """
    known = available(folder)
    found = fitted(campaign, effects or [], known, config, stream=stream)
    try:
        ranked, dropped = without_faulty(known.effects, found.ranked)
    except EffectFault as error:
        raise refused(error.fault) from error
    faults = report_faults([*known.faults, *dropped])
    if json:
        document = fit_document(found.title, found.names, found.robust)
        print_json({**document, "candidates": ranking_document(ranked), "faults": faults})
    else:
        console = Console(width=TABLE_WIDTH)
        console.print(headline(found.title, found.robust), highlight=False)
        console.print(_table(ranked))
    if out is not None:
        # Without pictures nothing waits for what draws them.
        from rigctl.cli.model.pictures import draw_ranking  # noqa: PLC0415

        draw_ranking(out, found.title, ranked)


def _table(ranked: Ranking) -> Table:
    table = Table(box=None)
    longest = max((len(candidate.effect.name) for candidate in ranked.candidates), default=0)
    table.add_column("effect", min_width=longest)
    for heading in ("score", "expected drop", "p", "amplitude", "unit", "", "like"):
        left = heading in {"unit", "", "like"}
        table.add_column(heading, justify="left" if left else "right")
    for k, candidate in enumerate(ranked.candidates):
        _add_candidate(table, candidate, alike(ranked, k))
    table.caption = (
        "p: chance that something in the catalogue looks as good when nothing is missing; like: "
        f"these shots do not distinguish it from this one (correlation above {SHOWN_ALIAS:g})"
    )
    return table


def _remark(candidate: Candidate) -> str:
    if candidate.of_measurement:
        return "of the images"
    return "" if candidate.plausible else "not plausible"


def _add_candidate(table: Table, candidate: Candidate, likes: list[str]) -> None:
    if not candidate.seen:
        table.add_row(candidate.effect.name, "", "", "", "cannot be seen with these shots")
        return
    parameter = candidate.effect.parameters[0]
    amplitude = Quantity(float(candidate.amplitudes[0]), float(candidate.sigmas[0]), parameter.unit)
    table.add_row(
        candidate.effect.name,
        f"{candidate.score:.1f}",
        f"{candidate.delta_chi2:.1f}",
        f"{candidate.p_familywise:.4f}",
        f"{parameter.symbol} = {amplitude.concise()}",
        unit_word(parameter.unit),
        _remark(candidate),
        ", ".join(likes),
    )
