"""`rigctl model propose`: the law that no catalogue holds, and its confirmation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from analysis.effects.effect import Effect
from analysis.effects.own.dropping import without_faulty
from analysis.errors import ProposalRefusedError
from analysis.launch.prediction import Limits
from analysis.model.data.tables import Data
from analysis.model.proposals.document import confirmation_document, together_document
from analysis.model.proposals.effect_file import written
from analysis.model.proposals.proposed import Proposed
from analysis.model.proposals.together import propose_read
from analysis.model.proposals.words import (
    confirmation_sentence,
    proposal_sentences,
    together_sentences,
)
from rigctl.cli.model.reading import opened, report_faults
from rigctl.cli.options import Campaign, Config, Json, OwnEffects, With, Workers
from rigctl.cli.output import TABLE_WIDTH, print_json, progress
from rigctl.config import load
from rigctl.errors import AnalysisInputError
from rigctl.model.known_effects import available, faults_refused
from rigctl.model.proposing import (
    confirmed,
    proposed_laws,
    read_for_together,
    shared_laws,
    unwritable,
)
from rigctl.model.seen_effects import require_seen
from rigctl.reanalysis import pool
from rigctl.sweeps.form import Sweep, write_sweep

SWEEP = "next_shots.toml"


def proposing(
    campaign: Campaign,
    *,
    effects: With = None,
    folder: OwnEffects = None,
    write: Annotated[
        Path | None, typer.Option(help="Write each proposal into this folder as an effect file.")
    ] = None,
    confirm: Annotated[
        Path | None,
        typer.Option(help="Test the form of this file on the shots it was not chosen on."),
    ] = None,
    together: Annotated[
        list[Path] | None,
        typer.Option(help="Ask this campaign as well: what do they share? Several times."),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(help="Work on campaigns asked together on this Dask scheduler's workers."),
    ] = None,
    workers: Workers = None,
    config: Config = None,
    json: Json = False,
) -> None:
    """Propose what depends on what, beside the named effects and all of the catalogue.

    Raises
    ------
    AnalysisInputError
        The campaign cannot be read, has too few shots, or an effect has a fault.
    NotFoundError
        No effect, or no campaign, has that name.
    StoreError
        The folder cannot be written.
    ConfigurationError
        No scheduler answers there, or the extra `dask` is not installed.
    """
    known = available(folder)
    given = [known.named(name, "--with") for name in effects or []]
    if confirm is not None:
        document = _confirming(campaign, given, confirm, config)
        _print(document, [confirmation_sentence(document)], as_json=json)
        return
    if together:
        campaigns = [campaign, *together]
        if scheduler is not None or workers is not None:
            read = partial(read_for_together, names=effects or (), folder=folder, config=config)
            document = _on_workers(campaigns, read, scheduler, workers)
        else:
            document = _together(campaigns, given, config)
        _print(document, together_sentences(document), as_json=json)
        return
    rig = load(config).limits
    limits = Limits(rig.pressure_kpa, rig.offset_mm)
    title, data = opened(campaign, config)
    with faults_refused(), progress() as report:
        require_seen(data, given, "--with")
        (found, document), dropped = without_faulty(
            known.effects,
            lambda left: proposed_laws(title, data, given, left, report=report, limits=limits),
        )
    document["faults"] = report_faults([*known.faults, *dropped])
    document["files"], document["sweep"] = [], None
    if write is not None:
        _write(write, title, found, document)
    lines = [*proposal_sentences(document), *(f"written: {path}" for path in document["files"])]
    if write is None and document["proposals"]:
        lines.append("--write FOLDER writes this as an effect file, its next shots as a sweep.")
    if document["sweep"]:
        lines.append(f"next shots, to be fired as a sweep: rigctl sweep {document['sweep']}")
    _print(document, lines, as_json=json)


def _confirming(
    campaign: Path, given: Sequence[Effect], file: Path, config: Path | None
) -> dict[str, Any]:
    """Test the form of a file on shots that it was not chosen on."""
    title, data = opened(campaign, config)
    with faults_refused(), progress() as report:
        report("testing the form")
        return confirmation_document(title, confirmed(title, data, given, file))


def _together(
    campaigns: Sequence[Path], given: Sequence[Effect], config: Path | None
) -> dict[str, Any]:
    """Ask several campaigns for what they share, and what each has for itself."""
    read = [opened(campaign, config) for campaign in campaigns]
    with faults_refused(), progress() as report:
        report("scoring forms in all campaigns")
        return shared_laws(read, given)


def _on_workers(
    campaigns: Sequence[Path],
    read: Callable[[Path], tuple[Data, tuple[Effect, ...]]],
    scheduler: str | None,
    workers: int | None,
) -> dict[str, Any]:
    """Ask the same; each campaign is read and worked on by the next free worker."""
    places = [campaign.resolve() if campaign.exists() else campaign for campaign in campaigns]
    titles = [place.name for place in places]
    with faults_refused(), pool(scheduler, workers) as workshop, progress() as say:
        say("scoring forms in all campaigns")
        try:
            found = propose_read(places, read, workshop.executor.map)
        except ProposalRefusedError as error:
            raise AnalysisInputError(str(error), part=", ".join(titles)) from error
    return together_document(titles, found)


def _write(folder: Path, title: str, found: Proposed, document: dict[str, Any]) -> None:
    """Write each proposal, and the next shots as a sweep beside them."""
    try:
        document["files"] = [str(path) for path in written(folder, title, found)]
    except OSError as error:
        raise unwritable(folder, error) from error
    shots = [shot for one in document["proposals"] for shot in one["next_shots"]]
    if shots:
        note = f"confirms a law proposed after {title}"
        write_sweep(folder / SWEEP, Sweep.model_validate({"note": note, "shots": shots}))
        document["sweep"] = str(folder / SWEEP)


def _print(document: dict[str, Any], lines: Sequence[str], *, as_json: bool) -> None:
    if as_json:
        print_json(document)
        return
    console = Console(width=TABLE_WIDTH)
    for line in lines:
        console.print(line, highlight=False, markup=False)
