"""How large slow errors are, from independent numbers that flights hold of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats

PRIOR_FACTOR = 2.0
"""One standard error of the prior of the size."""
SIZES = np.geomspace(1 / 16, 31.25, 80)
"""Over the prior's middle."""
ODD_SHARE = 0.1
"""Of films whose slow error has nothing to do with that of the others: shadows, a lost marker."""


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """Independent numbers of one film, each of variance 1 + gain s^2 with a slow error of size s.

    Attributes
    ----------
    gains
        Over the square of the unit of s, shape (n,).
    squares
        Shape (n,).
    """

    gains: Floats
    squares: Floats

    @classmethod
    def joined(cls, parts: Sequence[Evidence]) -> Evidence:
        """Return all numbers of several parts."""
        gains = [np.empty(0), *(part.gains for part in parts)]
        return cls(
            np.concatenate(gains), np.concatenate([np.empty(0), *(p.squares for p in parts)])
        )

    def log_likelihood(self, sizes: Floats) -> Floats:
        """Return that of each size."""
        variance = 1.0 + np.multiply.outer(sizes**2, self.gains)
        return np.asarray(-0.5 * (np.log(variance) + self.squares / variance).sum(axis=1))


def slow_size(films: Sequence[Evidence], middle: float, factor: float = PRIOR_FACTOR) -> float:
    """Return the root of the mean square of what the size of a slow error may be.

    A film may be an odd one, whose size says nothing of the others'.

    Parameters
    ----------
    middle
        Of the prior, in the unit of the size.
    factor
        One standard error of the prior. What an odd film's own size may be is as wide as ever.
    """
    posterior, wide = np.log(_prior(factor)), _prior(PRIOR_FACTOR)
    for film in films:
        own = film.log_likelihood(middle * SIZES)
        own = np.exp(own - own.max())
        posterior += np.log((1.0 - ODD_SHARE) * own + ODD_SHARE * float(own @ wide))
    weight = np.exp(posterior - posterior.max())
    return middle * float(np.sqrt(weight @ SIZES**2 / weight.sum()))


def _prior(factor: float) -> Floats:
    """Return the chances of the `SIZES` where one standard error is a factor."""
    chances = np.exp(-0.5 * (np.log(SIZES) / np.log(factor)) ** 2)
    return np.asarray(chances / chances.sum())
