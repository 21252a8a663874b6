"""A campaign fitted with effects of one's own choice, bad shots and frames left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from analysis.effects.effect import ContactLaw, Effect
from analysis.model.data.evidence import (
    Evidence,
    stage_of,
    weighed,
    weighed_again,
    with_jitter,
)
from analysis.model.data.inside import without_contact_frames
from analysis.model.data.stream import CampaignData
from analysis.model.data.tables import ContactTable
from analysis.model.fitting.account import Account
from analysis.model.fitting.adding import added, law_again
from analysis.model.fitting.air import with_measured_air
from analysis.model.fitting.fit import Fit, beside_field, fit_campaign
from analysis.model.fitting.slow_errors.sizes import with_measured_slow_errors

NOT_SHOWN = "too few frames show its spheres apart, before the contact or after it"
FAR = "chi-squared per degree of freedom {far:.3g} times that of the median shot"


@dataclass(frozen=True, slots=True, eq=False)
class RobustFit:
    """A campaign with a fit.

    Attributes
    ----------
    evidence
        Which shots and frames were used, and with which noise.
    data
        What was fitted.
    fit
        The fit.
    """

    evidence: Evidence
    data: CampaignData
    fit: Fit

    @property
    def rejected(self) -> list[int]:
        """Numbers of the shots that were left out."""
        return list(self.rejected_why)

    @property
    def rejected_why(self) -> dict[int, str]:
        """Why each shot was left out, by its number."""
        evidence = self.evidence
        why = dict.fromkeys(evidence.stated.unusable, NOT_SHOWN)
        for number in evidence.stated.shots[~evidence.cleaned.kept].tolist():
            why[number] = FAR.format(far=evidence.cleaned.far[number])
        return dict(sorted(why.items()))

    @property
    def excluded(self) -> list[int]:
        """Numbers of the shots that a person left out."""
        return list(self.evidence.stated.excluded)

    @property
    def account(self) -> Account:
        """What was left out, and how large the noise was taken to be."""
        evidence = self.evidence
        torn = () if isinstance(evidence.stated, ContactTable) else evidence.stated.torn
        return Account(
            self.excluded, self.rejected_why, evidence.cleaned.frames, evidence.noise, torn
        )

    def remarks(self) -> list[str]:
        """Say what was left out, and where stated sigmas were not believed."""
        return self.account.remarks()


def robust_fit(poses: CampaignData, effects: Sequence[Effect] = ()) -> RobustFit:
    """Fit the base model and some effects; what is bad is judged with these effects in."""
    stated = with_measured_slow_errors(with_measured_air(without_contact_frames(poses)))
    evidence = weighed(stated)
    return robust_fit_with(RobustFit(evidence, evidence.data, evidence.cleaned.fit), effects)


def robust_fit_with(base: RobustFit, effects: Sequence[Effect]) -> RobustFit:
    """Fit some effects on top of the base model's fit."""
    evidence, data, fit = base.evidence, base.data, base.fit
    if not effects:
        return base
    for effect in effects:
        data, fit = added(data, fit, effect)
    begun = stage_of(data, fit)
    again, path = weighed_again(evidence, [begun], data.jitter_s)
    for law in (effect for effect in effects if isinstance(effect, ContactLaw)):
        last = path[-1].fit
        theory = law_again(again, last, law) if last.theory.contact_law else last.theory
        if theory is not last.theory:
            better = stage_of(again.data, fit_campaign(again.data, theory))
            again, path = weighed_again(again, [better], data.jitter_s)
    if again is evidence and path[-1] is begun:
        return RobustFit(evidence, data, begun.fit)
    return RobustFit(again, again.data, path[-1].fit)


def on_shots_of(found: RobustFit, later: RobustFit) -> RobustFit:
    """Fit the effects of `found` to the shots, frames and noise that `later` is judged by.

    With more effects some shots come back that lay off without them: only on the same shots the
    errors of both compare.
    """
    data = later.data if found.data.jitter_s > 0 else with_jitter(later.data, 0.0)
    fit = beside_field(data, fit_campaign(data, found.fit.theory))
    return RobustFit(later.evidence, data, fit)
