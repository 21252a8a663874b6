"""The test for a random time error of each frame: a variance, not a shift, so not a score of means.

Of each shot, let r be the whitened residuals of a fit, D the whitened change of the prediction for
a unit of time in each frame (N x F, a frame's numbers in its own column), and P the projection off
everything fitted. With jitter of variance w and noise of scale f,

    cov r = f P + w P D D' P

The likelihood depends on w through q = D' r alone, with K = D' P D: cov q = f K + w K K. At w = 0
its derivative and the information are (C. R. Rao, Linear Statistical Inference (1973), 6e; the
dispersion f, fitted as chi-squared over the degrees of freedom n, is projected out)

    U = (q'q / f - tr K) / (2 f),   I = (tr K K - (tr K)^2 / n) / (2 f^2),   z = U / sqrt(I)

summed over shots. z is near a unit Gaussian when frames are taken on time. The amplitude is the
restricted likelihood's maximum: along the eigenvectors of K, of eigenvalues l, the squares of q
over l have the expectations f + w l; the other residuals, of square sum R, have f each. With
u = w / f, and f at its best for each u,

    -2 ln L = n ln f + sum ln(1 + u l),   n f = R + sum (q^2 / l) / (1 + u l)
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.special import ndtr

from analysis import chi_squared
from analysis.arrays import Floats

LEAST_EIGENVALUE = 1e-9
"""Below this share of the largest, a direction was fitted away: nothing of it is left."""
TIMES_BEYOND = 100.0


@dataclass(frozen=True, slots=True)
class JitterScore:
    """Score test of a jitter of the frame times.

    Attributes
    ----------
    z
        Score in its standard errors; jitter makes it positive.
    p_value
        Chance of a score as large when frames are taken on time, one-sided.
    amplitude, sigma
        Standard deviation of a frame's time by maximum likelihood, and its error, s; near zero,
        where likelihood has no curvature in it, the amplitude whose square is one standard error.
    delta_chi2
        Of minus twice the logarithm of the likelihood, from no jitter to that amplitude.
    p_delta_chi2
        Of that fall: half of one degree of freedom, as a variance cannot be negative.
    """

    z: float
    p_value: float
    amplitude: float
    sigma: float
    delta_chi2: float
    p_delta_chi2: float


@dataclass(frozen=True, slots=True, eq=False)
class Directions:
    """What the likelihood sees of some shots: directions that jitter moves, and all that is left.

    Attributes
    ----------
    values
        Eigenvalues l of the shots' K, shape (M,).
    squares
        q^2 along them, not yet over l, shape (M,).
    total
        Sum of the squares of all residuals.
    """

    values: Floats
    squares: Floats
    total: float


def directions(residual: Floats, along_track: Floats, kernel: Floats) -> Directions:
    """Return what the test sees of some shots: a time error that all numbers of a frame share.

    Positions and orientations must be whitened with true errors relative to each other; a common
    factor is estimated by `score_of`.

    Parameters
    ----------
    residual
        (observed - predicted) / sigma, zero where nothing was measured, (S, F, 2, 6).
    along_track
        Whitened rate of the prediction with time, 1/s, zero where not measured, (S, F, 2, 6):
        velocities and spins over sigma.
    kernel
        K = D' P D, 1/s^2, (S, F, F).
    """
    shots, frames = residual.shape[:2]
    rates = along_track.reshape(shots, frames, 12)
    pull = np.einsum("sfl,sfl->sf", rates, residual.reshape(shots, frames, 12))
    values, vectors = np.linalg.eigh((kernel + np.swapaxes(kernel, 1, 2)) / 2)
    along = (np.swapaxes(vectors, 1, 2) @ pull[..., None])[..., 0]
    return Directions(values.reshape(-1), along.reshape(-1) ** 2, float((residual**2).sum()))


def score_of(parts: Iterable[Directions], freedom: int) -> JitterScore:
    """Return the score of all shots, handed over in parts that are read several times.

    Parameters
    ----------
    freedom
        Degrees of freedom of the fit.

    Raises
    ------
    ValueError
        There are no degrees of freedom, or nothing moves.
    """
    if freedom <= 0:
        raise ValueError(f"{freedom} degrees of freedom, 1 is needed")
    largest = max((float(part.values.max(initial=0.0)) for part in parts), default=0.0)
    likelihood = _Likelihood(parts, LEAST_EIGENVALUE * max(largest, 1e-300), freedom)
    if likelihood.count == 0:
        raise ValueError("no time error shows: nothing moves in these frames")
    return _estimated(likelihood.z, likelihood)


class _Likelihood:
    """Directions that jitter moves, eigenvalues l and q^2 / l; the rest R; n in all."""

    def __init__(self, parts: Iterable[Directions], least: float, freedom: int) -> None:
        self._parts, self._least, self.freedom = parts, least, freedom
        self.total = sum(part.total for part in parts)
        self.count = sum(len(values) for values, _ in self._kept())
        self.push = sum(float(values @ squares) for values, squares in self._kept())
        self.trace = sum(float(values.sum()) for values, _ in self._kept())
        self.trace2 = sum(float(values @ values) for values, _ in self._kept())
        self.moved = sum(float(squares.sum()) for _, squares in self._kept())

    def _kept(self) -> Iterator[tuple[Floats, Floats]]:
        """Return l and q^2 / l of directions of which something is left, part by part."""
        for part in self._parts:
            kept = part.values > self._least
            values = part.values[kept]
            yield values, part.squares[kept] / values

    @property
    def z(self) -> float:
        """Return the score in its standard errors."""
        push = self.push * self.freedom / self.total - self.trace
        return push / float(np.sqrt(2.0 * (self.trace2 - self.trace**2 / self.freedom)))

    def noise(self, ratio: float) -> float:
        """Return f at u."""
        along = sum(float((s / (1.0 + ratio * v)).sum()) for v, s in self._kept())
        return (self.total - self.moved + along) / self.freedom

    def minus_twice_log(self, ratio: float) -> float:
        """Return -2 ln L at u, f at its best."""
        widened = sum(float(np.log1p(ratio * values).sum()) for values, _ in self._kept())
        return self.freedom * float(np.log(self.noise(ratio))) + widened

    def information(self, ratio: float) -> float:
        """Return the expected information on w at u, f fitted beside it, 1/s^4."""
        noise = self.noise(ratio)
        sums = np.zeros(3)
        for values, _ in self._kept():
            weight = 1.0 / (noise * (1.0 + ratio * values)) ** 2
            sums += [(weight * values**k).sum() for k in range(3)]
        others = (self.freedom - self.count) / noise**2
        return 0.5 * float(sums[2] - sums[1] ** 2 / (sums[0] + others))


def _estimated(z: float, likelihood: _Likelihood) -> JitterScore:
    """Maximise the likelihood over u >= 0."""
    most = TIMES_BEYOND * likelihood.moved / (likelihood.noise(np.inf) * likelihood.trace + 1e-300)
    found = minimize_scalar(
        likelihood.minus_twice_log,
        bounds=(0.0, most),
        method="bounded",
        options={"xatol": 1e-10 * most},
    )
    delta_chi2 = likelihood.minus_twice_log(0.0) - float(found.fun)
    ratio, delta_chi2 = (float(found.x), delta_chi2) if delta_chi2 > 0 else (0.0, 0.0)
    variance = ratio * likelihood.noise(ratio)
    amplitude = float(np.sqrt(variance))
    # Of the variance w; d s = d w / (2 s).
    spread = 1.0 / float(np.sqrt(likelihood.information(ratio)))
    return JitterScore(
        z=z,
        p_value=float(ndtr(-z)),
        amplitude=amplitude,
        sigma=min(spread / (2 * amplitude), spread**0.5) if amplitude > 0 else spread**0.5,
        delta_chi2=delta_chi2,
        p_delta_chi2=0.5 * float(chi_squared.chance_of_more(delta_chi2, 1))
        if delta_chi2 > 0
        else 1.0,
    )
