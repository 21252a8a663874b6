"""Errors of measuring and of the air that a fit pulls far from what is stated of them.

They are calibrated apart from any law. One that a fit wants three of its stated errors away mends
what the law lacks, or was stated wrongly: an alarm, and no measurement of it.
"""

from __future__ import annotations

from analysis.model.fitting.summary import FitSummary
from analysis.quantity import Quantity
from analysis.schema.verdict import Nuisance

MOST_PULL = 3.0
"""Stated errors; by chance it is in one fit of 370 for each."""


def nuisances(fit: FitSummary) -> tuple[Nuisance, ...]:
    """Return all that is stated beforehand, with what a fit makes of it."""
    found = fit.systematics()
    stated = [
        (f"{s.effect.name}.{p.symbol}", Quantity(float(value), s.sigma, p.unit))
        for s in fit.theory.systematics
        for p, value in zip(s.effect.parameters, s.stated, strict=True)
    ]
    return tuple(
        Nuisance(name, known, found[name], (found[name].value - known.value) / known.sigma)
        for name, known in stated
    )


def alarms_of(fit: FitSummary) -> tuple[Nuisance, ...]:
    """Return those beyond `MOST_PULL`, the farthest first."""
    far = [one for one in nuisances(fit) if abs(one.pull) > MOST_PULL]
    return tuple(sorted(far, key=lambda one: -abs(one.pull)))
