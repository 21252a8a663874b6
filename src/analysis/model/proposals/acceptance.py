"""What a form must pass: determined, not due to a few shots, and a better fit of shots left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from analysis.model.data.evidence import Stage, stage_of
from analysis.model.data.tables import Data
from analysis.model.fitting.adding import ALIAS_WITHIN
from analysis.model.fitting.fit import Fit
from analysis.model.proposals.admissible import LEAST_SIGMAS
from analysis.model.proposals.blocks import blocks_of
from analysis.model.proposals.channels import Form
from analysis.model.proposals.forms.impulses import IMPULSES
from analysis.model.proposals.products import main_groups
from analysis.model.proposals.proposed import Accepted
from analysis.model.proposals.refine import (
    CARRIERS,
    Refitted,
    Rival,
    ScoredForm,
    refitted,
    with_free_constants,
)
from analysis.model.proposals.screen import Screen
from analysis.model.rank.candidate import believed
from analysis.model.structure.influence import most_carried
from analysis.model.verdict.crossvalidation import (
    folds_by_chance,
    prediction_error,
    prediction_errors,
)

OPTIMISM = 2.0
"""Times its expected drop what a form may bring shots left out: scores are linear."""


@dataclass(frozen=True, slots=True, eq=False)
class Gate:
    """What a form is held against.

    Attributes
    ----------
    data, before
        What was fitted, and the point of the error path without the form.
    screen
        The scores of all forms there.
    name
        Of the form's effect in the fit.
    least_drop
        By how much it must lower the error on shots left out.
    """

    data: Data
    before: Stage
    screen: Screen
    name: str
    least_drop: float

    def may_help(self, scored: ScoredForm) -> bool:
        """Whether a form may lower the error on shots left out by as much as it must.

        Squares of shots left out fall by what chi-squared falls, less what chance brings.
        """
        error, noise = self.before.error, self.before.fit.chi2_per_dof
        counted = 0.5 / error.sampling**2
        needed = error.value**2 - max(error.value - self.least_drop, 0.0) ** 2
        return OPTIMISM * scored.delta_chi2 * noise > needed * counted

    def passed(self, chosen: Rival, rivals: Sequence[Rival]) -> Accepted | None:
        """Return a form as it goes in, with those of its rivals that are alike; None: it fails."""
        data, before = self.data, self.before
        scored = _scored(chosen)
        if _carried(scored, len(data.shots)) or not self.may_help(scored):
            return None
        found = _refitted(data, before.fit, chosen, self.name)
        least = found.worth - ALIAS_WITHIN
        found, freed = with_free_constants(data, found)
        if not _determined(found):
            return None
        folds = blocks_of(data)
        both = folds_by_chance(len(data.shots)), folds
        error, on_blocks = prediction_errors(data, found.fit, both)
        gains = np.sort(before.error.by_shot - error.by_shot)
        drop = before.error.value - error.value
        # Without the two that gain most, the others must gain too.
        if drop <= self.least_drop or gains[:-CARRIERS].sum() <= 0:
            return None
        if on_blocks.value >= prediction_error(data, before.fit, folds=folds).value:
            return None
        near = [one for one in rivals if one.worth > least]
        own = [one.form.shape_name for one in near if one.form.group == found.form.group]
        others = [one.form for one in near if one.form.group != found.form.group]
        groups = self.screen.groups()
        score = max((groups.get(group, 0.0) for group in groups_of(found)), default=0.0)
        return Accepted(
            found=found,
            shapes=tuple(dict.fromkeys([found.form.shape_name, *own])),
            alike=tuple(dict.fromkeys(form.group for form in others)),
            alike_effects=(),
            p_familywise=self.screen.p_familywise(score),
            before=before,
            after=stage_of(data, found.fit, error),
            freed=freed,
            rival=next((form for form in others if not _nearly_the_same(form, found.form)), None),
        )


def groups_of(one: Rival) -> set[tuple[str, str]]:
    """Return the groups in which a form is scored: of a freed product its arguments' too."""
    own = {one.form.group}
    return own | main_groups(one.form) if _scored(one).zeros_sought else own


def _scored(one: Rival) -> ScoredForm:
    return one.scored if isinstance(one, Refitted) else one


def _refitted(data: Data, fit: Fit, one: Rival, name: str) -> Refitted:
    return one if isinstance(one, Refitted) else refitted(data, fit, one, name)


def _nearly_the_same(first: Form, second: Form) -> bool:
    """Whether an impulse and the coefficient that sets it follow the same: no shots part them."""
    impulses = sum(form.slot in IMPULSES for form in (first, second))
    return first.argument == second.argument and impulses == 1


def _carried(scored: ScoredForm, shots: int) -> bool:
    """Whether two shots hold most of an expected drop, and the others hardly ask for it."""
    rest = scored.delta_chi2 * (1.0 - scored.carried_share)
    return scored.carried_share > most_carried(shots) and rest < LEAST_SIGMAS**2


def _determined(found: Refitted) -> bool:
    """Whether the amplitudes are in their ranges, and the largest is far from zero."""
    fit, count = found.fit, len(found.form.symbols)
    values = fit.theory.vector[-count:]
    sigmas = np.sqrt(np.diag(fit.covariance))[-count:] * np.sqrt(fit.chi2_per_dof)
    far = np.abs(values) > LEAST_SIGMAS * sigmas
    return bool(far.any()) and believed(found.form.effect(found.name), values, sigmas)
