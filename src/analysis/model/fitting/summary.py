"""What a fit says of a campaign, wherever the shots' own numbers are kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from analysis import chi_squared
from analysis.arrays import Floats
from analysis.effects.effect import ContactLaw
from analysis.model.predict.theory import LAW, LAW_PRIOR_SIGMA, Theory
from analysis.quantity import Quantity

KNOWN_BEFOREHAND, MOST_RANGES = 0.9, 10.0
"""A standard error as large as this share of the prior's, or as so many plausible ranges, is that
of a parameter without influence."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class FitSummary:
    """A fitted campaign without the states of its shots.

    Attributes
    ----------
    theory
        Law and effects at the minimum.
    covariance
        Of the theory's parameters, as the stated sigmas give it, shape (P, P).
    chi2, residuals
        Total chi-squared and number of residuals that enter it.
    shot_chi2, shot_residuals
        By shot, shape (S,).
    nuisance_count
        How many of each shot's own numbers the data determine, shape (S,).
    converged
        Whether a further step would lower chi-squared by less than what matters.
    by_field
        Of chi-squared, what errors that change with the place explain (`field_errors`), where it is
        more than chance; None: not asked, nor is it in the covariance what they do.
    scatter
        Parameters of noise that the data were given besides their sigmas.
    """

    theory: Theory
    covariance: Floats
    chi2: float
    residuals: int
    shot_chi2: Floats
    shot_residuals: NDArray[np.intp]
    nuisance_count: NDArray[np.intp]
    converged: bool
    by_field: float | None = None
    scatter: Mapping[str, Quantity] = field(default_factory=dict)

    @property
    def freedom(self) -> int:
        """Residuals less fitted numbers."""
        return self.residuals - int(self.nuisance_count.sum()) - len(self.theory.names)

    @property
    def chi2_per_dof(self) -> float:
        """Chi-squared per degree of freedom: 1 when nothing is missing and the sigmas are true."""
        return self.chi2 / max(self.freedom, 1)

    @property
    def p_chi2(self) -> float:
        """Chance of so large a chi-squared when nothing is missing and the sigmas are true."""
        return float(chi_squared.chance_of_more(self.chi2 - (self.by_field or 0.0), self.freedom))

    def parameters(self) -> dict[str, Quantity]:
        """Return law and effects with their standard errors.

        What the shots say nothing of is not determined: its prior is no result. A law that takes
        the operator's place has no beta0, and errors that hold what its other families would give.
        """
        start, stop, every = len(LAW), self.theory.given, self._every()
        law = [
            (name, _told(q, KNOWN_BEFOREHAND * prior))
            for (name, q), prior in zip(every[:start], LAW_PRIOR_SIGMA, strict=True)
            if name != "beta0" or self.theory.contact_law is None
        ]
        ranges = [np.ptp(p.plausible) for a in self.theory.active for p in a.effect.parameters]
        added = [
            (name, _told(_widened(q, spread), MOST_RANGES * float(wide)))
            for (name, q), spread, wide in zip(every[stop:], self._spreads(), ranges, strict=True)
        ]
        return {**dict(law), **dict(added), **self.scatter}

    def formulas(self) -> dict[str, str]:
        """Return the formula of each added effect with what its variant holds, by its name.

        Read with `parameters` it gives the fitted law, e at any speed say.
        """
        return {a.effect.name: a.effect.formula for a in self.theory.active}

    def _spreads(self) -> list[float]:
        """Return by how much families that are not told apart differ, for each added parameter."""
        found: list[float] = []
        for a in self.theory.active:
            spread = a.effect.spread if isinstance(a.effect, ContactLaw) else ()
            found += spread or (0.0,) * len(a.values)
        return found

    def systematics(self) -> dict[str, Quantity]:
        """Return the errors that all shots share: what was found of them and how well."""
        return dict(self._every()[len(LAW) : self.theory.given])

    def _every(self) -> list[tuple[str, Quantity]]:
        theory, sigma = self.theory, np.sqrt(np.diag(self.covariance))
        numbers = zip(theory.names, theory.vector, sigma, theory.units, strict=True)
        return [(name, Quantity(float(v), float(s), unit)) for name, v, s, unit in numbers]


def _widened(quantity: Quantity, spread: float) -> Quantity:
    """Return a quantity whose error holds a spread as well."""
    return replace(quantity, sigma=float(np.hypot(quantity.sigma, spread)))


def _told(quantity: Quantity, largest: float) -> Quantity:
    """Return a quantity, or that it is not determined where its error is not below a largest."""
    return quantity if quantity.sigma < largest else Quantity.undetermined(quantity.unit)
