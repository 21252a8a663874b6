"""The table of agreement: what stands in a line, and the chance of seeing as much by noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from analysis import chi_squared
from analysis.arrays import Floats
from analysis.model.fitting.noise import NoiseScale
from analysis.model.structure.alarm import UNEXPLAINED_LEVEL
from analysis.model.structure.lackoffit import holm
from analysis.model.verdict.crossvalidation import PredictionError

CARRIERS = 2


@dataclass(frozen=True, slots=True)
class Spread:
    """Mean and variance that a sum of squares has when nothing is missing."""

    mean: float
    variance: float

    @classmethod
    def less(cls, count: float, taken: Floats) -> Spread:
        """Return that of `count` squares of covariance 1 - T, T given by what has its traces."""
        trace, square = float(np.trace(taken)), float(np.trace(taken @ taken))
        return cls(count - trace, 2 * (count - 2 * trace + square))

    @property
    def sampling(self) -> float:
        """Standard deviation of the root of chi-squared over its mean."""
        return float(np.sqrt(max(self.variance, 0.0)) / (2 * max(self.mean, 1e-12)))

    def p_value(self, chi2: float) -> float:
        """Return the chance of a sum at least as large.

        By the chi-squared distribution of the same mean and variance: exact where the squares are
        those of a projection, else the approximation of F. E. Satterthwaite, Biometrics Bull. 2,
        110 (1946).
        """
        if self.mean <= 0 or self.variance <= 0:
            return 1.0
        return float(chi_squared.chance_of_more(chi2 * 2 * self.mean / self.variance, self.freedom))

    @property
    def freedom(self) -> float:
        """Degrees of freedom of that distribution."""
        return 2 * self.mean**2 / self.variance

    def p_rest(self, by_shot: Floats) -> float:
        """Return the chance of what a sum over shots (S,) is without its `CARRIERS` largest.

        Of the others mean and variance are in proportion. That the largest are out makes it larger
        than it is: no finding of few shots comes through.
        """
        rest = np.sort(by_shot)[:-CARRIERS]
        share = rest.size / max(by_shot.size, 1)
        return Spread(self.mean * share, self.variance * share).p_value(float(rest.sum()))


@dataclass(frozen=True, slots=True)
class Row:
    """One quantity.

    Attributes
    ----------
    quantity, unit
        Its name, and the unit of `size` and `floor`.
    count
        How many numbers it is made of.
    chi2, freedom
        Sum of squared whitened residuals of the fit, and what it is on average when nothing is
        missing and the errors are as stated: the count less what the fit took up of it.
    p_value, p_holm
        Chance of a chi2 at least as large by noise alone, and with all lines of its table looked
        at.
    error, sampling
        Whitened error of the prediction, floor 1, and its standard deviation when nothing is
        missing.
    size, floor
        Root mean square of that error in `unit`, and what the noise alone makes of it.
    p_rest
        Chance of what the others leave where the two shots with the largest share are out; None
        where it is not made up of shots.
    """

    quantity: str
    unit: str
    count: int
    chi2: float
    freedom: float
    p_value: float
    error: float
    sampling: float
    size: float
    floor: float
    p_rest: float | None = None
    p_holm: float = 1.0

    @property
    def shared(self) -> bool:
        """Whether it still disagrees without two of its shots, which may err by themselves."""
        return self.p_rest is None or self.p_rest < UNEXPLAINED_LEVEL


@dataclass(frozen=True, slots=True)
class Stage:
    """The quantities of one stage of the way from settings to image."""

    name: str
    rows: tuple[Row, ...]


@dataclass(frozen=True, slots=True)
class Agreement:
    """A fit held against its campaign.

    Attributes
    ----------
    stages
        In the order of nature.
    chi2, freedom, p_value
        Of all residuals together.
    prediction
        Whitened error of the poses after contact of shots left out.
    noise
        By what the scatter about free flights says the stated sigmas of positions and of
        orientations are to be multiplied.
    """

    stages: tuple[Stage, ...]
    chi2: float
    freedom: int
    p_value: float
    prediction: PredictionError
    noise: tuple[NoiseScale, NoiseScale]

    @property
    def rows(self) -> tuple[Row, ...]:
        """All lines of the table."""
        return tuple(row for stage in self.stages for row in stage.rows)


def looked_at_together(stages: Sequence[Stage]) -> tuple[Stage, ...]:
    """Return stages with p-values for having looked at all their lines; empty stages left out."""
    corrected = iter(holm(np.array([row.p_value for stage in stages for row in stage.rows])))
    return tuple(
        replace(
            stage, rows=tuple(replace(row, p_holm=float(next(corrected))) for row in stage.rows)
        )
        for stage in stages
        if stage.rows
    )


def root_mean(total: float, count: float) -> float:
    """Return the root of a mean of squares; 0 where there are none."""
    return float(np.sqrt(max(total, 0.0) / count)) if count > 0 else 0.0


def probability(p: float) -> str:
    """Return a probability as a table shows it, two digits at most."""
    if p >= 0.995:
        return "1"
    if p >= 0.001:
        return f"{p:.2g}"
    if p < 1e-99:
        return "< 1e-99"
    return f"{p:.0e}".replace("e-0", "e-")


def three_digits(value: float) -> str:
    """Return an error as a table shows it, three digits at least."""
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:#.3g}"
