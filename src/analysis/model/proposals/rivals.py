"""Forms that may be the one: those near the best score, refitted and put in order."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.model.data.tables import Data
from analysis.model.fitting.adding import ALIAS_WITHIN
from analysis.model.fitting.fit import Fit
from analysis.model.proposals.channels import Channels, Form
from analysis.model.proposals.forms.form import ContactForm
from analysis.model.proposals.forms.impulses import IMPULSES
from analysis.model.proposals.products import freed_products, main_groups
from analysis.model.proposals.refine import (
    MOST_GROUPS,
    Refitted,
    Rival,
    ScoredForm,
    refitted,
    score_forms,
    with_free_constants,
)
from analysis.model.proposals.screen import Screen
from analysis.model.rank.leaders import SMALL_FALL

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
    found = [p if exact and isinstance(p.form, ContactForm) else _refit(fitted, p) for p in near]
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


def _refit(fitted: tuple[Data, Fit, str], scored: ScoredForm) -> Refitted:
    data, fit, name = fitted
    found = refitted(data, fit, scored, name)
    # An exponent and a frequency are scored at a few values only.
    in_frames = not isinstance(scored.form, ContactForm)
    return with_free_constants(data, found)[0] if in_frames else found


def apart(rivals: Sequence[Rival]) -> list[Rival]:
    """Return the best form of each slot and argument, in order."""
    first: dict[tuple[str, str], Rival] = {}
    for one in rivals:
        first.setdefault(one.form.group, one)
    return list(first.values())
