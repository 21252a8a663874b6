"""Forms that may be the one: those near the best score, refitted and put in order."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.model.data.tables import Data
from analysis.model.fitting.adding import ALIAS_WITHIN
from analysis.model.fitting.fit import Fit
from analysis.model.proposals.channels import Channels, Form
from analysis.model.proposals.forms.form import ContactForm
from analysis.model.proposals.forms.impulses import IMPULSES
from analysis.model.proposals.products import freed_products
from analysis.model.proposals.refine import (
    MOST_GROUPS,
    Promise,
    Refitted,
    promised,
    refitted,
    with_free_constants,
)
from analysis.model.proposals.screen import Screen

SLACK = 8.0
"""Deviance by which finer constants and a refit may bring a group nearer to the best."""
MOST_FREED = 2
REFIT_SHARE = 0.1
"""Of the best promise, by which a refit may differ from it: promises are straight lines."""


def rivals_of(
    fitted: tuple[Data, Fit, str], channels: Channels, screen: Screen, forms: Sequence[Form]
) -> list[Refitted]:
    """Refit the groups whose scores come near the best; the most worth first.

    Parameters
    ----------
    fitted
        What was fitted, the fit, and the name that a form has in a refit.
    """
    sought = [promised(channels, group, forms) for group in _nearest(screen)]
    top = max((p.worth for promises in sought for p in promises), default=0.0)
    reach = ALIAS_WITHIN + SLACK / 2 + REFIT_SHARE * top
    found = []
    for promises in sought:
        least = promises[0].worth - ALIAS_WITHIN - 2.0 if promises else 0.0
        chosen = [p for p in promises if p.worth > least and _may_reach(p, top - reach)]
        found += [_refit(fitted, promise) for promise in chosen]
    freed = freed_products(channels, forms)[:MOST_FREED]
    least = (1.0 - REFIT_SHARE) * top
    found += _with_zeros(fitted, [p for p in freed if _may_reach(p, least)], found)
    return sorted(found, key=lambda one: -one.worth)


def _with_zeros(
    fitted: tuple[Data, Fit, str], promises: Sequence[Promise], others: Sequence[Refitted]
) -> list[Refitted]:
    """Refit products with their zeros free, and return those that are better than all else."""
    data, fit, name = fitted
    top = max((one.worth for one in others), default=0.0)
    freed = [with_free_constants(data, refitted(data, fit, p, name))[0] for p in promises]
    return [one for one in freed if one.worth > top]


def _nearest(screen: Screen) -> list[tuple[str, str]]:
    """Return the groups that come near the best, impulses beside so many of the other slots."""
    near = screen.near(ALIAS_WITHIN + SLACK)
    others = [group for group in near if group[0] not in IMPULSES][:MOST_GROUPS]
    return others + [group for group in near if group[0] in IMPULSES][: MOST_GROUPS // 2]


def _may_reach(promise: Promise, least: float) -> bool:
    """Whether a refit may bring a form so far; exponents in flight are tried too coarsely."""
    return promise.worth > least or not isinstance(promise.form, ContactForm)


def _refit(fitted: tuple[Data, Fit, str], promise: Promise) -> Refitted:
    data, fit, name = fitted
    found = refitted(data, fit, promise, name)
    # An exponent and a frequency are scored at a few values only.
    in_frames = not isinstance(promise.form, ContactForm)
    return with_free_constants(data, found)[0] if in_frames else found


def apart(rivals: Sequence[Refitted]) -> list[Refitted]:
    """Return the best form of each slot and argument, in order."""
    first: dict[tuple[str, str], Refitted] = {}
    for one in rivals:
        first.setdefault(one.form.group, one)
    return list(first.values())
