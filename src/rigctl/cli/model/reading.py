"""From a campaign to the fit that a command is about."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from analysis.effects.effect import Effect
from analysis.effects.own.fault import EffectFault, Fault
from analysis.model.data.gather import POSES, latest_table
from analysis.model.data.stream import CampaignData
from analysis.model.data.tables import ContactTable, Data
from analysis.model.fitting.fit import Fit
from analysis.model.fitting.robust_fit import RobustFit, robust_fit
from analysis.model.rank.candidate import Ranking
from analysis.model.rank.ranking import rank
from rigctl.model.campaigns import open_campaign, open_stream
from rigctl.model.known_effects import Available, refused
from rigctl.model.seen_effects import require_seen
from rigctl.temporary_room import temporary_room


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """A campaign with a fit: its name, the effects that were added, what was fitted and how."""

    title: str
    names: tuple[str, ...]
    robust: RobustFit

    @property
    def data(self) -> CampaignData:
        """What was fitted."""
        return self.robust.data

    @property
    def fit(self) -> Fit:
        """The fit."""
        return self.robust.fit

    def ranked(self, effects: Sequence[Effect]) -> Ranking:
        """Score what else the data ask for.

        Raises
        ------
        StoreError
            The campaign is streamed, and the temporary folder is full.
        """
        with temporary_room():
            return rank(self.data, self.fit, effects)


def opened(campaign: Path, configuration: Path | None = None) -> tuple[str, Data]:
    """Open a campaign; say on standard error which of several tables is taken, and unstated noise.

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
    _say_stage(title, campaign)
    _say_estimated(title, data)
    return title, data


def opened_in_parts(
    campaign: Path, configuration: Path | None = None, *, stream: bool
) -> tuple[str, CampaignData]:
    """Open a campaign that is gone over part by part.

    Parameters
    ----------
    stream
        Whether its poses are to lie in a temporary file; else in memory, as `opened` has them.

    Raises
    ------
    AnalysisInputError
        It cannot be read, or is to be streamed and holds no poses.csv.
    NotFoundError
        No campaign has that name.
    StoreError
        The temporary folder is full.
    """
    if not stream:
        return opened(campaign, configuration)
    title, data = open_stream(campaign, configuration)
    _say_estimated(title, data)
    return title, data


def _say_stage(title: str, campaign: Path) -> None:
    """Say which table of a folder is taken where its poses are there too, and say more."""
    if not (campaign / POSES).exists() or (table := latest_table(campaign)) == POSES:
        return
    Console(stderr=True, soft_wrap=True, markup=False, highlight=False).print(
        f"{title}: {table} is taken, the latest stage in {campaign}; its {POSES} says more, of "
        f"flight and camera above all: name {campaign / POSES} to have it fitted"
    )


def _say_estimated(title: str, data: CampaignData) -> None:
    if not data.estimated:
        return
    if isinstance(data, ContactTable):
        said = (
            "no errors are stated; the scatter about the base model is taken for them, so that its "
            "chi-squared says nothing"
        )
    else:
        said = "some errors are not stated; the scatter about free flight is taken for them"
    Console(stderr=True).print(f"{title}: {said}", highlight=False)


def fitted(
    campaign: Path,
    names: Sequence[str],
    known: Available,
    configuration: Path | None = None,
    *,
    stream: bool = False,
) -> Fitted:
    """Fit the base model and the named effects to a campaign, frames inside contact left out.

    Raises
    ------
    AnalysisInputError
        The campaign cannot be read, or a named effect has a fault or cannot be seen in it.
    NotFoundError
        No effect, or no campaign, has that name.
    StoreError
        The campaign is streamed, and the temporary folder is full.
    """
    added = [known.named(name, "--with") for name in names]
    title, found = opened_in_parts(campaign, configuration, stream=stream)
    try:
        with temporary_room():
            require_seen(found, added, "--with")
            return Fitted(title, tuple(names), robust_fit(found, added))
    except EffectFault as error:
        raise refused(error.fault) from error


def report_faults(faults: Sequence[Fault]) -> list[dict[str, Any]]:
    """Print each fault on standard error, and return all as a document has them."""
    console = Console(stderr=True, soft_wrap=True, markup=False, highlight=False)
    for fault in faults:
        console.print(f"rigctl: left out: {fault.sentence()}")
    return [fault.to_json() for fault in faults]
