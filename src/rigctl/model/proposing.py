"""A campaign asked for a law that no catalogue holds, as commands, jobs and Python ask it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from analysis.effects.effect import Effect
from analysis.errors import ProposalRefusedError
from analysis.launch.prediction import Limits
from analysis.model.data.tables import Data
from analysis.model.proposals.confirm import Confirmation, confirm, without_shots
from analysis.model.proposals.document import proposals_document
from analysis.model.proposals.effect_file import seen_shots
from analysis.model.proposals.following import next_after
from analysis.model.proposals.propose import Proposed, propose
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

    Raises
    ------
    AnalysisInputError
        The file holds no effect or has a fault, or too few shots are new to it.
    EffectFault
        An effect of the user's own fails.
    """
    known = available(file, part="--confirm")
    name = next(iter(known.files), None) or known.faults[0].effect
    effect, seen = known.named(name, "--confirm"), seen_shots(file)
    try:
        if seen is not None and seen[0] == title:
            data = without_shots(data, seen[1])
        return confirm(data, given, effect)
    except ProposalRefusedError as error:
        raise AnalysisInputError(str(error), part=title) from error


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
