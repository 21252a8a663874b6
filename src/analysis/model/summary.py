"""What a fit says of a campaign, wherever the shots' own numbers are kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from analysis.model.theory import Theory
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
        """Return every shared parameter with its standard error."""
        sigma = np.sqrt(np.diag(self.covariance))
        theory = self.theory
        shifts = {
            name: Quantity(float(value), float(s), unit)
            for name, value, s, unit in zip(
                theory.names, theory.vector, sigma, theory.units, strict=True
            )
        }
        return {**shifts, **self.scatter}
