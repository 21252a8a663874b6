"""From a campaign to the fit that a command is about."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from analysis.effects.own.fault import EffectFault
from analysis.model.fit import Fit, fit_campaign
from analysis.model.inside import without_contact_frames
from analysis.model.poses import PoseData
from rigctl.campaigns import open_campaign
from rigctl.commands.effect import Available, refused


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """A campaign with a fit: its name, the effects that were added, its poses, the fit."""

    title: str
    names: tuple[str, ...]
    data: PoseData
    fit: Fit


def fitted(campaign: Path, names: Sequence[str], known: Available) -> Fitted:
    """Fit the base model and the named effects to a campaign, frames inside contact left out.

    Raises
    ------
    AnalysisInputError
        The campaign cannot be read, or a named effect has a fault.
    NotFoundError
        No effect, or no campaign, has that name.
    """
    added = [known.named(name, "--with") for name in names]
    title, poses = open_campaign(campaign)
    data = without_contact_frames(poses)
    fit = fit_campaign(data)
    try:
        for effect in added:
            fit = fit_campaign(data, fit.theory.with_effect(effect), fit)
    except EffectFault as error:
        raise refused(error.fault) from error
    return Fitted(title, tuple(names), data, fit)
