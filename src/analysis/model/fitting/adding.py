"""One more effect in a fit, each kind in its way.

A fit of a contact that lasts begins from a scan of the laws: from where such a law is off it would
end in one of many wrong minima. What the flights before contact foretell of those after it is
compared, for each family from a few stiffness ratios on, the duration being what the paths show,
and goes down a loss that is as wide as what is left (`Scan.smoothed`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from analysis.arrays import Floats
from analysis.collision.force_law import hertz_duration, stated_modulus
from analysis.collision.operator import WaltonLaw
from analysis.effects.contact.lasting_contact import TYPICAL_MODULUS
from analysis.effects.effect import ContactLaw, Effect, ScatterEffect, Values
from analysis.model.data.evidence import Evidence
from analysis.model.data.stream import CampaignData
from analysis.model.data.tables import ContactTable
from analysis.model.fitting.fit import Fit, fit_campaign, parts_of, states_of_shots
from analysis.model.fitting.gauss_newton import TO_THE_END, Purpose
from analysis.model.fitting.lasting_scan import STEPS, Scan, Start
from analysis.model.fitting.normal import prior_cost
from analysis.model.fitting.outliers import robust_weight
from analysis.model.fitting.summary import FitSummary
from analysis.model.predict.free_flights import SIDE, FreeFlights, spread_flights
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
    begun = _starts(flights, law, fit.theory)
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


LEAST_SHOTS, FEW_SHOTS, MOST_SHOTS = 3, 24, 60
TYPICAL = tuple((ratio, 0.05) for ratio in (0.08, 0.2, 0.45, 1.0))
"""Stiffness ratios, and the tangential damping, that each family is gone down from."""
MIDDLE = 0.3, 0.05
RESTITUTIONS = 0.1, 0.999
REFINED, BEGUN = 12, 6
"""Minima that are refined with few shots, and with all."""
FAR_BEHIND = 30.0
"""Loss with few shots by which a minimum is behind the best, and not refined with all."""
UNDAMPED, AGAIN = 0.01, (0.6, 0.2)
"""Damping below which laws that differ by their damping are one: those near a law that came out so
are gone down to from another damping as well, at this share of its stiffness ratio."""
ALIKE = 0.02
TOLD_SIGMAS = 3.0
"""A duration that is not so many standard errors from zero, in the mean of all shots, is none."""


def _starts(flights: FreeFlights, law: ContactLaw, theory: Theory) -> list[Start]:
    """Return the likeliest of a law's families, each with its best values, the best first.

    Other effects that a theory has at the contact take part as they are. There are none where too
    few flights, or flights without spins, tell nothing of a law.
    """
    if len(flights.before) < LEAST_SHOTS or not flights.spins_seen.any():
        return []
    few = _scan(_spread(flights, FEW_SHOTS), theory, law)
    scanned: list[Start] = []
    for form in _leaders(law):
        timed = _timed(few, form)
        scanned += [Start(form, np.array([*timed[:3], *own]), np.inf) for own in TYPICAL]
    near = _distinct(few.smoothed(scanned))
    best = _distinct(few.about(near[0]).refined(near[:REFINED]))
    best = [one for one in best if one.cost < best[0].cost + FAR_BEHIND][:BEGUN]
    whole = _scan(flights, theory, law).about(best[0])
    led = _distinct(whole.refined(best))
    akin = [
        replace(begun, law=form)
        for one in led
        if one.cost < led[0].cost + FAR_BEHIND
        for form in one.law.akin
        for begun in _damped(one)
    ]
    return _distinct([*led, *whole.refined(akin)])


def _damped(found: Start) -> list[Start]:
    """Return where laws near one begin: where it is, and damped where it is not."""
    *others, ratio, damping = found.vector
    if damping > UNDAMPED:
        return [found]
    share, other = AGAIN
    return [found, replace(found, vector=np.array([*others, share * ratio, other]))]


def _spread(flights: FreeFlights, most: int) -> FreeFlights:
    """Return so many shots at most, spread over all."""
    count = len(flights.before)
    rows = np.linspace(0, count - 1, min(count, most)).round().astype(np.intp)
    return flights.of_shots(np.unique(rows))


def _leaders(law: ContactLaw) -> list[ContactLaw]:
    """Return a law and its variants without those that are looked for near another."""
    families = [form for form in (law, *law.variants) if isinstance(form, ContactLaw)]
    led = {id(other) for form in families for other in form.akin}
    return [form for form in families if id(form) not in led]


def _scan(flights: FreeFlights, theory: Theory, law: ContactLaw) -> Scan:
    """Begin about a contact as the stated material has it, or else nylon."""
    own = _own_coefficients(flights)
    modulus = stated_modulus(flights.bodies) or TYPICAL_MODULUS
    usual = hertz_duration(modulus, flights.bodies)
    e, middle = own.e, np.array([np.median(own.e), own.mu, usual, *MIDDLE])
    scan = Scan(flights, theory, e - middle[0], middle, np.zeros((len(e), SIDE, SIDE)), STEPS)
    scan = replace(scan, middle=_timed(scan, law))
    for _ in range(2):
        e = _corrected(scan, law)
        middle = np.array([np.median(e), *scan.middle[1:]])
        scan = replace(scan, own_e=e - middle[0], middle=middle)
    return scan.about(Start(law, scan.middle, 0.0))


def _distinct(found: list[Start]) -> list[Start]:
    """Return starts, the best first, without those that came out where a better one is."""
    kept: list[Start] = []
    for one in sorted(found, key=lambda each: each.cost):
        if not any(
            one.law is other.law and np.allclose(one.vector, other.vector, rtol=ALIKE, atol=1e-3)
            for other in kept
        ):
            kept.append(one)
    return kept


@dataclass(frozen=True, slots=True, eq=False)
class _Coefficients:
    """Restitution of each contact, shape (S,), and a friction that four of five do not exceed."""

    e: Floats
    mu: float


def _own_coefficients(flights: FreeFlights) -> _Coefficients:
    still = np.zeros(len(flights.before))
    encounter, _ = flights.encounter(flights.before, still, 0.0)
    normal, velocities = encounter.normal, flights.after.reshape(-1, 3, 2, 3)[:, 1]
    change = velocities[:, 1] - velocities[:, 0]
    change = change - (encounter.before.velocity_b - encounter.before.velocity_a)
    along = (change * normal).sum(axis=1)
    across = np.linalg.norm(change - along[:, None] * normal, axis=1)
    e = np.clip(along / encounter.approach - 1.0, *RESTITUTIONS)
    mu = float(np.quantile(across / np.maximum(along, 1e-9), 0.8).clip(0.005, 1.5))
    return _Coefficients(np.asarray(e), mu)


def _corrected(scan: Scan, law: ContactLaw) -> Floats:
    """Return each contact's restitution so that a law makes of it the normal velocity it has.

    So what else restitution may depend on does not touch the choice of the law.
    """
    flights, operator = scan.flights, scan.operator(law, scan.middle[2:])
    e, mu = scan.middle[0] + scan.own_e, float(scan.middle[1])
    encounter, _ = flights.encounter(flights.before, e, mu)
    found = flights.foretold(flights.before, operator, e, mu)
    off = (flights.after - found).reshape(-1, 3, 2, 3)[:, 1]
    along = ((off[:, 1] - off[:, 0]) * encounter.normal).sum(axis=1)
    own = np.nan_to_num(e + along / encounter.approach, nan=0.5)
    return np.asarray(np.clip(own, *RESTITUTIONS))


def _timed(scan: Scan, law: ContactLaw) -> Floats:
    """Return a start with the duration that paths or rows show, or as it is where none does.

    Durations go with that at 1 m/s, however a law has them depend on speed.
    """
    flights, vector = scan.flights, scan.middle
    operator = scan.operator(law, vector[2:])
    encounter, _ = flights.encounter(flights.before, vector[0] + scan.own_e, float(vector[1]))
    ratio = flights.durations() / operator(encounter).duration
    ratio = ratio[np.isfinite(ratio)]
    if ratio.size == 0:
        return vector
    middle = float(np.median(ratio))
    spread = 1.4826 * float(np.median(np.abs(ratio - middle))) / np.sqrt(ratio.size)
    if middle < TOLD_SIGMAS * spread:
        return vector
    low, high = law.parameters[0].possible
    return np.array([*vector[:2], np.clip(vector[2] * middle, low, high), *vector[3:]])
