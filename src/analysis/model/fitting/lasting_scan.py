"""Flights compared across contacts that last, at many values of a law at once, and refined."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from analysis.arrays import Floats
from analysis.collision.operator import Operator
from analysis.effects.effect import ContactLaw, Values
from analysis.model.predict.free_flights import SIDE, FreeFlights
from analysis.model.predict.theory import Theory

FAR, KNOWN = 1e6, 1e3
LEAST, MOST = (0.05, 1e-3), (1.2, 3.0)
"""Of e and mu."""
STEPS, ROUGH_STEPS = 40, 16
"""Integration steps of an undamped contact, in a scan and in its first, wide stages. They are fewer
than in a fit: a scan only compares laws, and the fit gives the values."""
SMOOTHED = 2
"""Times that a start is gone down a wider loss first."""
EVALUATIONS, FEW_EVALUATIONS = 15, 4
LITTLE_FALL = 0.1
"""Of the loss: two steps in a row that bring no more are the last, or one by slopes taken there."""
RELATIVE_STEP, LEAST_STEP = 1e-4, 1e-7
"""Of differences."""
SMALLEST = 1e-12
"""Of the largest curvature: along less a step is not determined."""
Scales = Callable[[Floats], Floats]
"""From residuals (V, R) to how wide the loss of each V is."""
DAMPING, EASED, RAISED, LARGEST_DAMPING = 1e-3, 0.1, 10.0, 1e4


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """A law with values to begin a fit at.

    Attributes
    ----------
    vector
        e, mu and the values of the law's parameters.
    cost
        Cauchy's loss on the flights after contact; the least is the likeliest law.
    """

    law: ContactLaw
    vector: Floats
    cost: float

    @property
    def values(self) -> Values:
        """Of the law's own parameters."""
        return self.vector[2:]


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """Flights compared across their contacts.

    Attributes
    ----------
    theory
        Its other effects act at contact.
    own_e
        By what each contact's restitution differs from that of all, shape (S,).
    middle
        Where the scan begins.
    whitening
        Of the flights after contact, shape (S, 18, 18).
    steps
        In which contacts are integrated.
    """

    flights: FreeFlights
    theory: Theory
    own_e: Floats
    middle: Floats
    whitening: Floats
    steps: int

    def about(self, start: Start) -> Scan:
        """Return the scan with errors carried through the contact of a start."""
        return replace(self, whitening=_whitening(self, start.law, start.vector))

    def operator(self, law: ContactLaw, values: Floats) -> Operator:
        """Return the law at some values, shape (K,) or (K, N), with the other effects round it."""
        stepped, steps = law.stepped, self.steps
        if stepped is not None:
            law = replace(law, law=lambda own: stepped(own, steps))
        return self.theory.with_effect(law, values).operator

    def residuals(self, law: ContactLaw, vectors: Floats) -> Floats:
        """Return what e, mu and the law's values (V, K) leave of the flights after, (V, R).

        A contact that does not part is as far off as can be.
        """
        flights, count = self.flights, len(self.own_e)
        each = np.repeat(vectors, count, axis=0)
        e = (vectors[:, :1] + self.own_e).ravel()
        operator = self.operator(law, each[:, 2:].T)
        before = np.repeat(flights.before[None], len(vectors), axis=0).reshape(-1, SIDE)
        found = flights.foretold(before, operator, e, each[:, 1])
        off = flights.after - found.reshape(len(vectors), count, SIDE)
        left = (self.whitening @ off[..., None]).reshape(len(vectors), -1)
        return np.where(np.isfinite(left), left, FAR)

    def costs(self, law: ContactLaw, vectors: Floats) -> Floats:
        """Return Cauchy's loss at values (V, K), shape (V,)."""
        return _loss(self.residuals(law, vectors), np.ones(len(vectors)))

    def smoothed(self, starts: Sequence[Start]) -> list[Start]:
        """Return starts nearer to their minima, with Cauchy's loss there.

        They go down a loss that is as wide as what they leave, so that a minimum narrower than the
        way to it is not missed (A. Blake and A. Zisserman, Visual Reconstruction, 1987).
        """
        found: list[Start] = []
        roughly = replace(self, steps=ROUGH_STEPS)
        for law, begun in _by_law(starts):
            vectors = begun
            for _ in range(SMOOTHED):
                vectors, _ = roughly._lowered(law, vectors, _scales, FEW_EVALUATIONS)
            costs = self.costs(law, vectors)
            found += [Start(law, v, float(c)) for v, c in zip(vectors, costs, strict=True)]
        return sorted(found, key=lambda one: one.cost)

    def refined(self, starts: Sequence[Start]) -> list[Start]:
        """Return the minima of Cauchy's loss below some starts, the least first."""
        found: list[Start] = []
        for law, vectors in _by_law(starts):
            each = self._lowered(law, vectors, _unit_scales, EVALUATIONS)
            found += [Start(law, v, float(c)) for v, c in zip(*each, strict=True)]
        return sorted(found, key=lambda one: one.cost)

    def _lowered(
        self, law: ContactLaw, vectors: Floats, scales_of: Scales, evaluations: int
    ) -> tuple[Floats, Floats]:
        """Go down from values (V, K) by steps of Levenberg and Marquardt, all side by side.

        D. W. Marquardt, J. SIAM 11, 431 (1963); residuals weighed as the loss weighs them, whose
        second derivatives are negative beyond its scale and lead nowhere. Slopes follow the steps
        (C. G. Broyden, Math. Comput. 19, 577 (1965)) and are taken anew where those lead no lower.

        Returns
        -------
        Values and their losses at scales of the residuals there (V,), shapes (V, K) and (V,).
        """
        low, high = bounds(law)
        vectors = np.clip(vectors, low, high)
        left, slopes = self._linear(law, vectors)
        scales = scales_of(left)
        costs, damping = _loss(left, scales), np.full(len(vectors), DAMPING)
        going = np.arange(len(vectors))
        fresh, rested = np.ones((2, len(vectors)), dtype=np.bool_) & [[True], [False]]
        for _ in range(evaluations):
            wide = scales[going, None]
            step = _steps(left[going] / wide, slopes[going] / wide[..., None], damping[going])
            moved = np.clip(vectors[going] + step, low, high)
            tried = self.residuals(law, moved)
            falls = costs[going] - _loss(tried, scales[going])
            better, idle = falls > 0, np.abs(falls) < LITTLE_FALL
            damping[going] *= np.where(better, EASED, np.where(fresh[going], RAISED, 1.0))
            rows = going[better]
            slopes[rows] = _followed(
                slopes[rows], moved[better] - vectors[rows], left[rows] - tried[better]
            )
            vectors[rows], left[rows] = moved[better], tried[better]
            costs[rows] -= falls[better]
            at_rest = idle & (fresh | rested)[going]
            ended = at_rest | (fresh[going] & (damping[going] >= LARGEST_DAMPING))
            stale = going[~fresh[going] & ~better & ~ended]
            fresh[rows], rested[going] = False, idle
            if stale.size:
                left[stale], slopes[stale] = self._linear(law, vectors[stale])
                fresh[stale] = True
            going = going[~ended]
            if not going.size:
                break
        return vectors, costs

    def _linear(self, law: ContactLaw, vectors: Floats) -> tuple[Floats, Floats]:
        """Return residuals (V, R) and by what each parameter lowers them (V, R, K), in one call."""
        low, high = bounds(law)
        least = LEAST_STEP * np.minimum(high - low, 1.0)
        size = np.maximum(RELATIVE_STEP * np.abs(vectors), least)
        steps = np.where(vectors + size > high, -size, size)
        count, width = vectors.shape
        nodes = np.repeat(vectors[:, None], width + 1, axis=1)
        nodes[:, 1:] += steps[:, :, None] * np.eye(width)
        left = self.residuals(law, nodes.reshape(-1, width)).reshape(count, width + 1, -1)
        slopes = (left[:, :1] - left[:, 1:]) / steps[..., None]
        return left[:, 0].copy(), np.swapaxes(slopes, 1, 2).copy()


def _by_law(starts: Sequence[Start]) -> Iterator[tuple[ContactLaw, Floats]]:
    """Yield each law among starts with its values, shape (V, K)."""
    for law in {id(one.law): one.law for one in starts}.values():
        yield law, np.array([one.vector for one in starts if one.law is law])


def _loss(residuals: Floats, scales: Floats) -> Floats:
    """Return Cauchy's loss of residuals (V, R) over scales (V,): a large one smooths it."""
    return np.asarray(np.log1p((residuals / scales[:, None]) ** 2).sum(axis=1))


def _unit_scales(residuals: Floats) -> Floats:
    return np.ones(len(residuals))


def _scales(residuals: Floats) -> Floats:
    """Return how wide residuals (V, R) scatter, 1 at least, by their median, shape (V,)."""
    told = np.where(residuals == 0.0, np.nan, np.abs(residuals))
    seen = np.asarray(np.isfinite(told).any(axis=1, keepdims=True))
    middle = np.nanmedian(np.where(seen, told, 0.0), axis=1)
    return np.asarray(np.maximum(1.4826 * middle, 1.0))


def bounds(law: ContactLaw) -> tuple[Floats, Floats]:
    """Return the least and the largest e, mu and values of a law, shape (K,) each."""
    low, high = zip(*(parameter.possible for parameter in law.parameters), strict=True)
    return np.array([*LEAST, *low]), np.array([*MOST, *high])


def _followed(slopes: Floats, steps: Floats, falls: Floats) -> Floats:
    """Return slopes (V, R, K) that give the falls (V, R) of residuals along steps (V, K).

    Each parameter counts by what it does to the residuals.
    """
    off = falls - (slopes @ steps[..., None])[..., 0]
    along = (slopes**2).sum(axis=1) * steps
    length = np.maximum((along * steps).sum(axis=1), 1e-300)
    return np.asarray(slopes + off[..., None] * (along / length[:, None])[:, None])


def _steps(left: Floats, slopes: Floats, damping: Floats) -> Floats:
    """Return damped steps down Cauchy's loss of residuals (V, R) in units of its scale, (V, K)."""
    weight = 1.0 / (1.0 + left**2)
    across = np.swapaxes(slopes, 1, 2)
    matrix = across @ (weight[..., None] * slopes)
    pull = (across @ (weight * left)[..., None])[..., 0]
    unit = np.sqrt(np.maximum(np.diagonal(matrix, axis1=1, axis2=2), 1e-300))
    scaled = matrix / unit[:, :, None] / unit[:, None, :]
    scaled += damping[:, None, None] * np.eye(matrix.shape[1])
    values, vectors = np.linalg.eigh(scaled)
    told = values > SMALLEST * values[:, -1:]
    share = np.where(told, 1.0 / np.where(told, values, 1.0), 0.0)
    along = (np.swapaxes(vectors, 1, 2) @ (pull / unit)[..., None])[..., 0]
    return np.asarray((vectors @ (share * along)[..., None])[..., 0] / unit)


def _whitening(scan: Scan, law: ContactLaw, vector: Floats) -> Floats:
    """Return what whitens the flights after contact as foretold from those before, (S, 18, 18).

    The covariance is that of the former, and of the latter carried through the contact, and what
    all shots share carried likewise: a scale that is off by its stated error moves both sides by
    ten errors of their own, and a wrong law makes up for it.
    """
    flights, operator = scan.flights, scan.operator(law, vector[2:])
    count = len(flights.before)
    sigma = np.sqrt(np.diagonal(flights.before_covariance, axis1=1, axis2=2))
    known = np.asarray(sigma < KNOWN)
    steps = np.where(known, np.maximum(0.3 * sigma, 1e-9), 0.0)
    moved = np.repeat(flights.before[None], 1 + SIDE, axis=0)
    moved[1 + np.arange(SIDE), :, np.arange(SIDE)] += steps.T
    e = np.tile(vector[0] + scan.own_e, 1 + SIDE)
    found = flights.foretold(moved.reshape(-1, SIDE), operator, e, float(vector[1]))
    found = found.reshape(1 + SIDE, count, SIDE)
    slopes = (found[1:] - found[0]) / np.where(steps > 0, steps, 1.0).T[..., None]
    slopes = np.moveaxis(np.where(np.isfinite(slopes), slopes, 0.0), 0, 2)
    before = np.where(known[:, :, None] & known[:, None, :], flights.before_covariance, 0.0)
    # A spin that was not seen before contact leaves what friction does to either side open.
    blind = np.asarray(~known.all(axis=1))
    carried = slopes @ before @ np.swapaxes(slopes, 1, 2) + flights.after_covariance
    shared = flights.after_shared - slopes @ np.where(known[..., None], flights.before_shared, 0.0)
    carried += shared @ np.swapaxes(shared, 1, 2)
    scale = np.sqrt(np.diagonal(carried, axis1=1, axis2=2))
    unit = carried / scale[:, :, None] / scale[:, None, :] + 1e-9 * np.eye(SIDE)
    root = np.linalg.inv(np.linalg.cholesky(unit)) / scale[:, None, :]
    return np.asarray(np.where(blind[:, None, None], 0.0, root))
