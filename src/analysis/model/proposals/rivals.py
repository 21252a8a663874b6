"""Forms that may be the one: those near the best score, refitted, and what each must pass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.model.data.evidence import Stage, stage_of
from analysis.model.data.tables import Data
from analysis.model.fitting.adding import ALIAS_WITHIN
from analysis.model.fitting.fit import Fit
from analysis.model.fitting.gauss_newton import Purpose
from analysis.model.fitting.normal import prior_cost
from analysis.model.proposals.admissible import LEAST_SIGMAS
from analysis.model.proposals.arguments import Argument
from analysis.model.proposals.blocks import blocks_of
from analysis.model.proposals.channels import Channels, Form
from analysis.model.proposals.forms.form import ContactForm
from analysis.model.proposals.forms.impulses import IMPULSES
from analysis.model.proposals.forms.shapes import LINEAR, POWER
from analysis.model.proposals.proposed import Accepted
from analysis.model.proposals.refine import (
    CARRIERS,
    MOST_GROUPS,
    Refitted,
    Rival,
    ScoredForm,
    refitted,
    score_forms,
    with_free_constants,
)
from analysis.model.proposals.screen import Screen
from analysis.model.rank.candidate import believed
from analysis.model.rank.leaders import SMALL_FALL, WITHIN
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
    """Return a form fitted to the end: refits of some were left when others were likelier."""
    if isinstance(one, Refitted) and one.fit.converged:
        return one
    return refitted(data, fit, _scored(one), name)


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


SLACK = 8.0
"""Deviance by which finer constants and a refit may bring a group nearer to the best."""
MOST_FREED = 2
REFIT_SHARE = 0.1
"""Of the largest expected drop, by which a refit may differ from it: scores are linear."""
FARTHEST_OFF, STRAIGHT_TO = 0.9, 1000.0
"""Share of a drop by which the expected one may miss it where large, and how large that is."""


def least_beside(worth: float) -> float:
    """Return the worth by score below which nothing of another kind comes near this worth.

    Scores are linear: exact where a drop is small, and ever less the larger it is.
    """
    share = min(FARTHEST_OFF, REFIT_SHARE + worth / STRAIGHT_TO)
    return worth * (1.0 - share) - ALIAS_WITHIN - SLACK / 2


def score_groups(channels: Channels, screen: Screen, forms: Sequence[Form]) -> list[ScoredForm]:
    """Return the likeliest forms of the groups whose scores come near the best, best first."""
    found = [p for group in _nearest(screen) for p in score_forms(channels, group, forms)]
    return sorted(found, key=lambda scored: -scored.worth)


def rivals_of(
    fitted: tuple[Data, Fit, str],
    channels: Channels,
    scored_forms: Sequence[ScoredForm],
    forms: Sequence[Form],
    known: float = 0.0,
) -> list[Rival]:
    """Return the forms that come near the best, refitted where a refit may change their order.

    Parameters
    ----------
    fitted
        What was fitted, the fit, and the name that a form has in a refit.
    scored_forms
        As `score_groups` returns them.
    known
        Worth of the best effect of the catalogue, refitted.

    Returns
    -------
    The most worth first.
    """
    top = max((scored.worth for scored in scored_forms), default=0.0)
    if top < least_beside(known):
        return []
    least = top - ALIAS_WITHIN - SLACK / 2 - REFIT_SHARE * top
    near = [scored for scored in scored_forms if _may_reach(scored, least)]
    exact = max((scored.delta_chi2 for scored in near), default=0.0) < SMALL_FALL
    found: list[Rival] = []
    for one in near:
        held = exact and isinstance(one.form, ContactForm)
        found.append(one if held else _refit(fitted, one, _bar(fitted[1], found)))
    found.sort(key=lambda one: -one.worth)
    products = freed_products(channels, forms)
    leading: list[Rival] = [*products[:MOST_FREED]]
    if not exact:
        least = (1.0 - REFIT_SHARE) * top
        leading = [_freed(fitted, p) for p in products[:MOST_FREED] if p.worth > least]
    best = found[0].worth if found else 0.0
    leading = [product for product in leading if product.worth > best]
    return sorted([*leading, *found, *_alike(found, products)], key=lambda one: -one.worth)


def _freed(fitted: tuple[Data, Fit, str], product: ScoredForm) -> Rival:
    """Refit a product with its zeros free."""
    data, fit, name = fitted
    return with_free_constants(data, refitted(data, fit, product, name))[0]


def _alike(found: Sequence[Rival], products: Sequence[ScoredForm]) -> list[ScoredForm]:
    """Return the likeliest product of the argument that leads, where shots do not rule it out.

    A product whose zero lies off the shots is nearly its other argument by itself.
    """
    if not found:
        return []
    lead = found[0]
    scored = lead.scored if isinstance(lead, Refitted) else lead
    within = scored.worth - ALIAS_WITHIN
    own = (p for p in products if lead.form.group in main_groups(p.form))
    return [p for p in own if within < p.worth <= scored.worth][:1]


def _nearest(screen: Screen) -> list[tuple[str, str]]:
    """Return the groups that come near the best, impulses beside so many of the other slots."""
    near = screen.near(ALIAS_WITHIN + SLACK)
    others = [group for group in near if group[0] not in IMPULSES][:MOST_GROUPS]
    return others + [group for group in near if group[0] in IMPULSES][: MOST_GROUPS // 2]


def _may_reach(scored: ScoredForm, least: float) -> bool:
    """Whether a refit may bring a form so far; exponents in flight are tried too coarsely."""
    return scored.worth > least or not isinstance(scored.form, ContactForm)


def _bar(fit: Fit, found: Sequence[Rival]) -> float:
    """Return the cost above which a further form is neither the best nor alike."""
    refits = [one.fit for one in found if isinstance(one, Refitted)]
    best = min(refits, key=lambda one: one.chi2, default=None)
    if best is None:
        return float(np.inf)
    fall = fit.chi2 - best.chi2
    alike = (ALIAS_WITHIN + SLACK / 2) * max(best.chi2_per_dof, 1.0)
    return best.chi2 + prior_cost(best.theory) + max(alike, WITHIN * fall)


def _refit(fitted: tuple[Data, Fit, str], scored: ScoredForm, bar: float) -> Refitted:
    data, fit, name = fitted
    # An exponent and a frequency are scored at a few values only.
    in_frames = not isinstance(scored.form, ContactForm)
    if in_frames:
        return with_free_constants(data, refitted(data, fit, scored, name))[0]
    return refitted(data, fit, scored, name, Purpose(beat=bar))


def apart(rivals: Sequence[Rival]) -> list[Rival]:
    """Return the best form of each slot and argument, in order."""
    first: dict[tuple[str, str], Rival] = {}
    for one in rivals:
        first.setdefault(one.form.group, one)
    return list(first.values())


FARTHEST = 20.0
"""Of a zero from the mean of the shots, in their standard deviations: beyond it one argument is as
good as alone."""


def freed_products(channels: Channels, forms: Sequence[Form]) -> list[ScoredForm]:
    """Return every product with its zeros where the shots want them, the most worth first.

    a (x - x0) (y - y0) is a x y + b x + c y beside a constant: three columns say how far
    chi-squared falls with both zeros free. About the means of the shots the product alone may say
    little, where a law as T ln(v_n / (1 m/s)) acts mostly through one argument.
    """
    products = [f for f in forms if isinstance(f, ContactForm) and len(f.arguments) == 2]
    if not products:
        return []
    mains = {
        (form.slot, argument.key): alone(form, place)
        for form in products
        for place, argument in enumerate(form.arguments)
    }
    columns: list[ContactForm] = [*products, *mains.values()]
    sums = channels.summed([channels.weights(form) for form in columns])
    places = {key: len(products) + k for k, key in enumerate(mains)}
    found = []
    for k, form in enumerate(products):
        rows = np.array([k, *(places[form.slot, a.key] for a in form.arguments)])
        if not sums.seen[rows].all():
            continue
        block = sums.of(rows)
        solved: Floats = np.asarray(
            np.linalg.lstsq(block.matrix, block.gradient, rcond=1e-10)[0], np.float64
        )
        moved = _at_zeros(form, solved, channels)
        if moved is not None:
            delta_chi2 = float(block.gradient @ solved) / channels.noise_scale**2
            found.append(ScoredForm(moved, delta_chi2, solved[:1], 0.0, zeros_sought=True))
    return sorted(found, key=lambda scored: -scored.worth)


def main_groups(form: Form) -> set[tuple[str, str]]:
    """Return what a product says where one of its arguments does not change."""
    arguments: tuple[Argument, ...] = form.arguments if isinstance(form, ContactForm) else ()
    return {(form.slot, argument.name) for argument in arguments}


def alone(form: ContactForm, place: int) -> ContactForm:
    """Return one argument of a product by itself, with the zero that it has in the product."""
    argument, zero = form.arguments[place], form.constants[place]
    shape = POWER if argument.positive else LINEAR
    return ContactForm(form.slot, (argument,), shape, (zero,), (1.0,))


def _at_zeros(form: ContactForm, solved: Floats, channels: Channels) -> ContactForm | None:
    """Return a product with its zeros where a fit of three columns has them; None: too far off."""
    both, first, second = (float(value) for value in solved)
    if both == 0.0:
        return None
    zeros = []
    for argument, zero, other in zip(form.arguments, form.constants, (second, first), strict=True):
        way = -other / both
        numbers = argument.of(channels.encounter)[:, 0]
        spread = np.log(np.maximum(numbers, 1e-9)).std() if argument.positive else numbers.std()
        if abs(way) > FARTHEST * float(spread):
            return None
        zeros.append(zero * float(np.exp(way)) if argument.positive else zero + way)
    moved = form.at(*zeros)
    largest = float(np.abs(moved.columns(channels.encounter)).max())
    return ContactForm(form.slot, form.arguments, form.shape, moved.constants, (largest,))
