"""Errors of measuring and of the air that a fit pulls far from what is stated of them.

They are calibrated apart from any law. One that a fit wants three of its stated errors away mends
what the law lacks, or was stated wrongly: an alarm, and no measurement of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from analysis.model.fitting.summary import FitSummary
from analysis.quantity import Quantity

Json = dict[str, Any]

MOST_PULL = 3.0
"""Stated errors; by chance it is in one fit of 370 for each."""


@dataclass(frozen=True, slots=True)
class Nuisance:
    """One parameter that all shots share and that is stated beforehand.

    Attributes
    ----------
    name
        `effect.symbol`.
    stated, found
        What is stated of it, and what the fit makes of it.
    """

    name: str
    stated: Quantity
    found: Quantity

    @property
    def pull(self) -> float:
        """Return how many stated errors the fit has it from its stated value."""
        return (self.found.value - self.stated.value) / self.stated.sigma

    def to_json(self) -> Json:
        """Return it as documents hold it."""
        return {
            "nuisance": self.name,
            "stated": self.stated.to_json(),
            "found": self.found.to_json(),
            "pull": self.pull,
        }


def nuisances(fit: FitSummary) -> list[Nuisance]:
    """Return all that is stated beforehand, with what a fit makes of it."""
    found = fit.systematics()
    stated = [
        (f"{s.effect.name}.{p.symbol}", Quantity(float(value), s.sigma, p.unit))
        for s in fit.theory.systematics
        for p, value in zip(s.effect.parameters, s.stated, strict=True)
    ]
    return [Nuisance(name, known, found[name]) for name, known in stated]


def alarms_of(fit: FitSummary) -> list[Json]:
    """Return those beyond `MOST_PULL`, the farthest first, as documents hold them."""
    far = [one for one in nuisances(fit) if abs(one.pull) > MOST_PULL]
    return [one.to_json() for one in sorted(far, key=lambda one: -abs(one.pull))]
