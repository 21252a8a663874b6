"""Where fits of a contact that lasts begin: laws scanned from one side of the contact to the other.

From where such a law is off a fit ends in one of many wrong minima. What the flights before contact
foretell of those after it is compared, for each family from a few stiffness ratios on, the duration
being what the paths show, and goes down a loss that is as wide as what is left (`Scan.smoothed`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from analysis.arrays import Floats
from analysis.collision.force_law import hertz_duration, stated_modulus
from analysis.effects.contact.lasting_contact import TYPICAL_MODULUS
from analysis.effects.effect import ContactLaw
from analysis.model.fitting.lasting_scan import STEPS, Scan, Start
from analysis.model.predict.free_flights import SIDE, FreeFlights
from analysis.model.predict.theory import Theory

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


def starts(flights: FreeFlights, law: ContactLaw, theory: Theory) -> list[Start]:
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
