"""What a fit says of a campaign, wherever the shots' own numbers are kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from analysis.model.theory import LAW, Theory
from analysis.quantity import Quantity

Floats = NDArray[np.float64]


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
    own_numbers
        How many of each shot's own numbers the data determine, shape (S,).
    converged
        Whether a further step would lower chi-squared by less than what matters.
    scatter
        Parameters of noise that the data were given besides their sigmas.
    """

    theory: Theory
    covariance: Floats
    chi2: float
    residuals: int
    shot_chi2: Floats
    shot_residuals: NDArray[np.intp]
    own_numbers: NDArray[np.intp]
    converged: bool
    scatter: Mapping[str, Quantity] = field(default_factory=dict)

    @property
    def freedom(self) -> int:
        """Residuals less fitted numbers."""
        return self.residuals - int(self.own_numbers.sum()) - len(self.theory.names)

    @property
    def chi2_per_dof(self) -> float:
        """Chi-squared per degree of freedom: 1 when nothing is missing and the sigmas are true."""
        return self.chi2 / max(self.freedom, 1)

    def parameters(self) -> dict[str, Quantity]:
        """Return law and effects with their standard errors."""
        start, stop, every = len(LAW), self.theory.given, self._every()
        return {**dict(every[:start]), **dict(every[stop:]), **self.scatter}

    def systematics(self) -> dict[str, Quantity]:
        """Return the errors that all shots share: what was found of them and how well."""
        return dict(self._every()[len(LAW) : self.theory.given])

    def _every(self) -> list[tuple[str, Quantity]]:
        theory, sigma = self.theory, np.sqrt(np.diag(self.covariance))
        numbers = zip(theory.names, theory.vector, sigma, theory.units, strict=True)
        return [(name, Quantity(float(v), float(s), unit)) for name, v, s, unit in numbers]
