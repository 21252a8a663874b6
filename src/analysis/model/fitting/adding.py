"""One more effect in a fit, each kind in its way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from analysis.collision.operator import WaltonLaw
from analysis.effects.effect import ContactLaw, Effect, ScatterEffect, Values
from analysis.model.data.evidence import Evidence
from analysis.model.data.stream import CampaignData
from analysis.model.data.tables import ContactTable
from analysis.model.fitting.fit import Fit, fit_campaign, parts_of, states_of_shots
from analysis.model.fitting.gauss_newton import TO_THE_END, Purpose
from analysis.model.fitting.lasting_scan import Start
from analysis.model.fitting.lasting_start import MOST_SHOTS, starts
from analysis.model.fitting.normal import prior_cost
from analysis.model.fitting.outliers import robust_weight
from analysis.model.fitting.summary import FitSummary
from analysis.model.predict.free_flights import spread_flights
from analysis.model.predict.theory import LAW_PRIOR, Theory
from analysis.model.rank.scatter import timing_jitter, with_jitter

ALIAS_WITHIN = (2 * 1.2816) ** 2
"""Difference of deviance below which the better of two fits is the wrong one in more than one of
ten campaigns."""
RIVAL_SHOTS = 40
"""Of a campaign of twice as many and more, so many are asked first whether a family may win."""
TRUSTED_NEAR = 1.03
"""Times its expected drop a family begun near its minimum comes down: 1.003 to 1.024 seen."""
NEAR, MOST_STARTS = 20.0, 4
"""Starts whose loss in the scan is this near the least are fitted, so many at most."""


def added(
    data: CampaignData, fit: Fit, effect: Effect, purpose: Purpose = TO_THE_END
) -> tuple[CampaignData, Fit]:
    """Fit again with one more effect; one that is noise of its own enters the data's noise."""
    if isinstance(effect, ContactLaw):
        return data, with_law(data, fit, effect, (data, fit))
    if not isinstance(effect, ScatterEffect):
        return data, fit_campaign(data, fit.theory.with_effect(effect), fit, purpose)
    score = timing_jitter(data, fit)
    if score is None or isinstance(data, ContactTable):
        return data, fit
    return with_jitter(data, fit, effect, score.amplitude, score.sigma)


def law_again(evidence: Evidence, fit: Fit, law: ContactLaw) -> Theory:
    """Return the theory with the law looked for once more, in all shots.

    The hard-sphere operator does not fit the very shots that tell one law from another, and they
    were left out. Now that a law is in they count again; those it does not explain are held down.
    """
    whole = evidence.whole
    first = fit_campaign(whole, fit.theory)
    held = whole.held_down(robust_weight(first))
    begun = fit_campaign(held, fit.theory, first)
    again = with_law(held, begun, law, (whole, first))
    return again.theory if again.chi2 < begun.chi2 - ALIAS_WITHIN else fit.theory


def with_law(data: CampaignData, fit: Fit, law: ContactLaw, seen: tuple[CampaignData, Fit]) -> Fit:
    """Fit again with another law of contact, in its likeliest family.

    The law does not contain the present one, whose fit may be bent: it begins from a scan, with the
    errors that shots share as they are stated, and all other families from the best one's states.

    Parameters
    ----------
    data, fit
        The campaign with its present fit.
    seen
        The same for the scan, where sigmas are other ones.

    Returns
    -------
    The fit; the present one where these shots tell nothing of such a law.
    """
    flights = spread_flights(parts_of(*seen), fit.theory, len(data.shots), MOST_SHOTS)
    begun = starts(flights, law, fit.theory)
    if not begun:
        return fit
    near = [one for one in begun if one.cost < begun[0].cost + NEAR][:MOST_STARTS]
    near += [replace(begun[0], law=other) for other in begun[0].law.beside]
    # States about the operator are bent by it; about another family of such laws they are not.
    inside = fit.theory.contact_law is not None
    first = _theory(fit.theory, near[0])
    if inside:
        best = fit_campaign(data, first, fit, Purpose(beat=_cost(fit)))
    else:
        best = fit_campaign(data, first)
    tried = [best]
    for one in near[1:]:
        theory = _theory(best.theory, one)
        if _may_be_better(data, theory, best):
            tried.append(fit_campaign(data, theory, best, Purpose(beat=_cost(best) + ALIAS_WITHIN)))
            best = min(best, tried[-1], key=lambda each: each.chi2)
    return _with_spread(best, tried)


def _with_spread(best: Fit, tried: Sequence[Fit]) -> Fit:
    """Return the likeliest family's fit with how far the values of those like it lie from its own.

    Each family counts by its likelihood: J. A. Hoeting, D. Madigan, A. E. Raftery and C. T.
    Volinsky, Statist. Sci. 14, 382 (1999). One that these shots exclude counts for nothing.
    """
    law = best.theory.contact_law
    others = [one for one in tried if one.theory.contact_law is not None]
    if law is None or len(others) < 2:
        return best
    weights = np.exp(-0.5 * np.array([one.chi2 - best.chi2 for one in others]))
    own = _law_values(best)
    apart = np.array([_law_values(one) - own for one in others])
    spread = np.sqrt(weights @ apart**2 / weights.sum())
    told = replace(law, spread=tuple(map(float, spread)))
    active = (replace(a, effect=told) if a.effect is law else a for a in best.theory.active)
    return replace(best, theory=replace(best.theory, active=tuple(active)))


def _law_values(fit: Fit) -> Values:
    """Return the values of the parameters of a fit's law of contact."""
    return next(a.values for a in fit.theory.active if isinstance(a.effect, ContactLaw))


def _may_be_better(data: CampaignData, theory: Theory, best: Fit) -> bool:
    """Say whether some of the shots leave it open that another family is better.

    Fitted to these alone it has an advantage; one that is behind all the same by `ALIAS_WITHIN` is
    hardly ever ahead with all of them.
    """
    count = len(data.shots)
    if count < 2 * RIVAL_SHOTS:
        return True
    chosen = np.zeros(count, dtype=np.bool_)
    chosen[np.linspace(0, count - 1, RIVAL_SHOTS).round().astype(np.intp)] = True
    begun = replace(best, parts=states_of_shots(data, best, chosen))
    present = float(best.shot_chi2[chosen].sum()) + prior_cost(best.theory) + ALIAS_WITHIN
    purpose = Purpose(beat=present, enough=present, trusted=TRUSTED_NEAR)
    other = fit_campaign(data.of_shots(chosen), theory, begun, purpose)
    return float(other.shot_chi2.sum()) + prior_cost(other.theory) < present


def _cost(fit: FitSummary) -> float:
    return fit.chi2 + prior_cost(fit.theory)


def _theory(theory: Theory, start: Start) -> Theory:
    calibrated = tuple(replace(s, values=s.stated) for s in theory.systematics)
    begun = replace(
        theory,
        law=WaltonLaw(float(start.vector[0]), float(start.vector[1]), LAW_PRIOR[2]),
        systematics=calibrated,
        active=tuple(a for a in theory.active if a.effect.name != start.law.name),
    )
    return begun.with_effect(start.law, start.values)
