"""From a campaign to the fit that a command is about."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from analysis.effects.effect import Effect
from analysis.effects.own.fault import EffectFault, Fault
from analysis.model.data.tables import ContactTable, Data
from analysis.model.fitting.fit import Fit
from analysis.model.fitting.robust_fit import Judged, judged
from analysis.model.rank.candidate import Ranking
from analysis.model.rank.ranking import rank
from analysis.model.streaming.judged import JudgedStream, judged_stream
from rigctl.model.campaigns import open_campaign
from rigctl.model.known_effects import Available, refused
from rigctl.model.seen_effects import require_seen
from rigctl.model.streamed_campaigns import open_stream
from rigctl.temporary_room import temporary_room


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """A campaign with a fit: its name, the effects that were added, what was fitted and how."""

    title: str
    names: tuple[str, ...]
    judged: Judged

    @property
    def data(self) -> Data:
        """What was fitted."""
        return self.judged.data

    @property
    def fit(self) -> Fit:
        """The fit."""
        return self.judged.fit

    def ranked(self, effects: Sequence[Effect]) -> Ranking:
        """Score what else the data ask for."""
        return rank(self.data, self.fit, effects)


@dataclass(frozen=True, slots=True, eq=False)
class FittedStream:
    """The same of a campaign of any length."""

    title: str
    names: tuple[str, ...]
    judged: JudgedStream

    def ranked(self, effects: Sequence[Effect]) -> Ranking:
        """Score what else the data ask for.

        Raises
        ------
        StoreError
            The temporary folder is full.
        """
        with temporary_room():
            return self.judged.ranked(effects)


def opened(campaign: Path, configuration: Path | None = None) -> tuple[str, Data]:
    """Open a campaign; say on standard error where its noise is not stated.

    Parameters
    ----------
    configuration
        Of the rig whose store holds a campaign that is named; None: the simulated rig's.

    Raises
    ------
    AnalysisInputError
        It cannot be read.
    NotFoundError
        No campaign has that name.
    """
    title, data = open_campaign(campaign, configuration)
    if isinstance(data, ContactTable) and data.estimated:
        Console(stderr=True).print(
            f"{title}: no errors are stated; the scatter about the base model is taken for them, "
            "so that its chi-squared says nothing",
            highlight=False,
        )
    elif data.estimated:
        _say_estimated(title)
    return title, data


def _say_estimated(title: str) -> None:
    Console(stderr=True).print(
        f"{title}: some errors are not stated; the scatter about free flight is taken for them",
        highlight=False,
    )


def fitted(
    campaign: Path, names: Sequence[str], known: Available, configuration: Path | None = None
) -> Fitted:
    """Fit the base model and the named effects to a campaign, frames inside contact left out.

    Raises
    ------
    AnalysisInputError
        The campaign cannot be read, or a named effect has a fault or cannot be seen in it.
    NotFoundError
        No effect, or no campaign, has that name.
    """
    added = [known.named(name, "--with") for name in names]
    title, found = opened(campaign, configuration)
    try:
        require_seen(found, added, "--with")
        return Fitted(title, tuple(names), judged(found, added))
    except EffectFault as error:
        raise refused(error.fault) from error


def fitted_stream(
    campaign: Path, names: Sequence[str], known: Available, configuration: Path | None = None
) -> FittedStream:
    """Fit the same to a campaign of any length, its poses in a temporary file.

    Raises
    ------
    AnalysisInputError
        The campaign cannot be read or holds no poses.csv, or a named effect has a fault.
    NotFoundError
        No effect, or no campaign, has that name.
    StoreError
        The temporary folder is full.
    """
    added = [known.named(name, "--with") for name in names]
    title, stream = open_stream(campaign, configuration)
    if stream.estimated:
        _say_estimated(title)
    try:
        with temporary_room():
            return FittedStream(title, tuple(names), judged_stream(stream, added))
    except EffectFault as error:
        raise refused(error.fault) from error


def tell(faults: Sequence[Fault]) -> list[dict[str, Any]]:
    """Say each fault on standard error, and return all as a document has them."""
    console = Console(stderr=True, soft_wrap=True, markup=False, highlight=False)
    for fault in faults:
        console.print(f"rigctl: left out: {fault.sentence()}")
    return [fault.to_json() for fault in faults]
