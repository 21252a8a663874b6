"""A campaign asked for a law that no catalogue holds, as commands, jobs and Python ask it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from analysis.effects.catalogue import CATALOGUE
from analysis.effects.effect import Effect
from analysis.errors import ProposalRefusedError
from analysis.launch.prediction import Limits
from analysis.model.data.tables import Data
from analysis.model.proposals.confirm import (
    Confirmation,
    confirm,
    confirm_stated,
    without_shots,
)
from analysis.model.proposals.document import proposals_document, together_document
from analysis.model.proposals.effect_file import origin
from analysis.model.proposals.following import next_after
from analysis.model.proposals.propose import propose
from analysis.model.proposals.proposed import Proposed
from analysis.model.proposals.stated import Statement, numbers_among, read_statement
from analysis.model.proposals.together import propose_together
from rigctl.documents import Json
from rigctl.errors import AnalysisInputError, StoreError
from rigctl.model.known_effects import available


def proposed_laws(
    title: str,
    data: Data,
    given: Sequence[Effect],
    catalogue: Sequence[Effect],
    *,
    report: Callable[[str], None],
    limits: Limits | None = None,
) -> tuple[Proposed, Json]:
    """Return what is proposed, and its document with the next shots.

    Raises
    ------
    AnalysisInputError
        There are too few shots.
    EffectFault
        An effect of the user's own fails.
    """
    try:
        found = propose(data, given, catalogue, report)
    except ProposalRefusedError as error:
        raise AnalysisInputError(str(error), part=title) from error
    if found.accepted or found.launch:
        report("choosing shots")
    return found, proposals_document(title, found, next_after(found, limits))


def confirmed(title: str, data: Data, given: Sequence[Effect], file: Path) -> Confirmation:
    """Test the form of a file on the shots of a campaign that it has not seen.

    Parameters
    ----------
    file
        An effect's file, or one that states a form: `*.json`.

    Raises
    ------
    AnalysisInputError
        The file holds no effect or has a fault, or too few shots are new to it.
    EffectFault
        An effect of the user's own fails.
    """
    if file.suffix == ".json":
        try:
            stated = read_statement(file)
        except ProposalRefusedError as error:
            raise AnalysisInputError(str(error), part="--confirm") from error
        return confirmed_statement(title, data, given, stated)
    known = available(file, part="--confirm")
    name = next(iter(known.files), None) or known.faults[0].effect
    effect, chosen_on = known.named(name, "--confirm"), origin(file)
    try:
        if chosen_on is not None:
            given = _beside(chosen_on.beside, given)
            if chosen_on.campaign == title:
                data = without_shots(data, numbers_among(chosen_on.shots, data.shots))
        return confirm(data, given, effect)
    except ProposalRefusedError as error:
        raise AnalysisInputError(str(error), part=title) from error


def confirmed_statement(
    title: str, data: Data, given: Sequence[Effect], stated: Statement
) -> Confirmation:
    """Test a form that is stated on the shots of a campaign that it has not seen.

    Raises
    ------
    AnalysisInputError
        It is no form, the campaign has not what it follows, or too few shots are new to it.
    """
    try:
        if stated.campaign == title:
            data = without_shots(data, numbers_among(stated.shots, data.shots))
        return confirm_stated(data, _beside(stated.beside, given), stated)
    except ProposalRefusedError as error:
        raise AnalysisInputError(str(error), part=title) from error


def _beside(names: Sequence[str], given: Sequence[Effect]) -> tuple[Effect, ...]:
    """Return the effects given, and those of the catalogue that a form was chosen beside.

    Raises
    ------
    AnalysisInputError
        One is neither given nor in the catalogue.
    """
    found = {effect.name: effect for effect in given}
    known = {effect.name: effect for effect in CATALOGUE}
    for name in names:
        if name in found:
            continue
        if name not in known:
            raise AnalysisInputError(
                f"the form was chosen beside {name}, which the catalogue does not hold",
                part="--confirm",
                todo=f"name it: --with {name} --effects FOLDER",
            )
        found[name] = known[name]
    return tuple(found.values())


def shared_laws(campaigns: Sequence[tuple[str, Data]], given: Sequence[Effect]) -> Json:
    """Return the document of what several campaigns ask for together, each by title and data.

    Raises
    ------
    AnalysisInputError
        A campaign has too few shots, or they share no argument.
    """
    titles = [title for title, _ in campaigns]
    try:
        found = propose_together([data for _, data in campaigns], given)
    except ProposalRefusedError as error:
        raise AnalysisInputError(str(error), part=", ".join(titles)) from error
    return together_document(titles, found)


def read_for_together(
    campaign: Path, names: Sequence[str], folder: Path | None, config: Path | None
) -> tuple[Data, tuple[Effect, ...]]:
    """Return a campaign's data and the effects of these names: what a worker does first."""
    from rigctl.model.campaigns import open_campaign  # noqa: PLC0415 - needs a Unix: the store

    known = available(folder)
    given = tuple(known.named(name, "--with") for name in names)
    return open_campaign(campaign, config)[1], given


def unwritable(folder: Path, error: OSError) -> StoreError:
    """Return the error of a folder that takes no file."""
    return StoreError(f"cannot be written: {error}", part=str(folder))
