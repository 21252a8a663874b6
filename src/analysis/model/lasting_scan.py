"""Flights compared across contacts that last, at many values of a law at once, and refined."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.collision.operator import Operator
from analysis.effects.effect import ContactLaw, Values
from analysis.model.free_flights import SIDE, FreeFlights
from analysis.model.theory import Theory

Floats = NDArray[np.float64]

FAR, KNOWN = 1e6, 1e3
ROUGH = 5.0
"""Standard errors by which a grid may miss a minimum: its nodes are no nearer."""
LEAST, MOST = (0.05, 1e-3), (1.2, 3.0)
"""Of e and mu."""
EVALUATIONS = 15
LITTLE_FALL = 0.02
"""Of the loss: a step that brings no more is the last."""
RELATIVE_STEP, LEAST_STEP = 1e-4, 1e-7
"""Of differences."""
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
    scale
        Of the loss, in standard errors.
    """

    flights: FreeFlights
    theory: Theory
    own_e: Floats
    middle: Floats
    whitening: Floats
    scale: float = 1.0

    def about(self, start: Start) -> Scan:
        """Return the scan with errors carried through the contact of a start."""
        return replace(self, whitening=_whitening(self, start.law, start.vector))

    def operator(self, law: ContactLaw, values: Floats) -> Operator:
        """Return the law at some values, shape (K,) or (K, N), with the other effects round it."""
        return self.theory.with_effect(law, values).operator

    def residuals(self, law: ContactLaw, vectors: Floats) -> Floats:
        """Return what e, mu and the law's values (V, K) leave of the flights after, (V, R).

        A contact that does not part is as far off as can be.
        """
        flights, count = self.flights, len(self.own_e)
        each = np.repeat(vectors, count, axis=0)
        e = each[:, 0] + np.tile(self.own_e, len(vectors))
        operator = self.operator(law, each[:, 2:].T)
        before = np.tile(flights.before, (len(vectors), 1))
        found = flights.foretold(before, operator, e, each[:, 1])
        off = flights.after - found.reshape(len(vectors), count, SIDE)
        left = (self.whitening @ off[..., None]).reshape(len(vectors), -1)
        return np.where(np.isfinite(left), left, FAR)

    def costs(self, law: ContactLaw, vectors: Floats) -> Floats:
        """Return Cauchy's loss at values (V, K), shape (V,)."""
        return self.loss(self.residuals(law, vectors))

    def loss(self, residuals: Floats) -> Floats:
        """Return Cauchy's loss of residuals (..., R) over the scale: a large one smooths it."""
        return np.asarray(np.log1p((residuals / self.scale) ** 2).sum(axis=-1))

    def refined(self, start: Start) -> Start:
        """Return where Cauchy's loss is least, from a start on, by way of its least when rough."""
        for scale in (ROUGH, 1.0):
            start = replace(self, scale=scale)._lowered(start)
        return start

    def _lowered(self, start: Start) -> Start:
        """Go down by steps of Levenberg and Marquardt: D. W. Marquardt, J. SIAM 11, 431 (1963).

        Second derivatives of the loss are taken where they are positive.
        """
        low, high = bounds(start.law)
        vector = np.clip(start.vector, low, high)
        left, slopes = self._linear(start.law, vector)
        cost, damping = float(self.loss(left)), DAMPING
        for _ in range(EVALUATIONS):
            step = _step(left / self.scale, slopes / self.scale, damping)
            moved = np.clip(vector + step, low, high)
            tried, turned = self._linear(start.law, moved)
            fall = cost - float(self.loss(tried))
            if fall > 0:
                vector, left, slopes, cost = moved, tried, turned, cost - fall
                damping *= EASED
            elif damping > LARGEST_DAMPING:
                break
            else:
                damping *= RAISED
            if abs(fall) < LITTLE_FALL:
                break
        return Start(start.law, vector, cost)

    def _linear(self, law: ContactLaw, vector: Floats) -> tuple[Floats, Floats]:
        """Return residuals (R,) and by what each parameter lowers them (R, K), all in one call."""
        low, high = bounds(law)
        size = np.maximum(RELATIVE_STEP * np.abs(vector), LEAST_STEP * np.minimum(high - low, 1.0))
        steps = np.where(vector + size > high, -size, size)
        nodes = np.concatenate([vector[None], vector + np.diag(steps)])
        left = self.residuals(law, nodes)
        return left[0], ((left[0] - left[1:]) / steps[:, None]).T


def bounds(law: ContactLaw) -> tuple[Floats, Floats]:
    """Return the least and the largest e, mu and values of a law, shape (K,) each."""
    low, high = zip(*(parameter.possible for parameter in law.parameters), strict=True)
    return np.array([*LEAST, *low]), np.array([*MOST, *high])


def _step(left: Floats, slopes: Floats, damping: float) -> Floats:
    """Return a damped step down Cauchy's loss of residuals in units of its scale."""
    square = left**2
    curvature = np.clip((1.0 - square) / (1.0 + square) ** 2, 0.0, None)
    matrix = slopes.T @ (curvature[:, None] * slopes)
    pull = slopes.T @ (left / (1.0 + square))
    unit = np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    scaled = matrix / unit[:, None] / unit + damping * np.eye(len(unit))
    return np.asarray(np.linalg.lstsq(scaled, pull / unit, rcond=1e-12)[0] / unit)


def _whitening(scan: Scan, law: ContactLaw, vector: Floats) -> Floats:
    """Return what whitens the flights after contact as foretold from those before, (S, 18, 18).

    The covariance is that of the former, and of the latter carried through the contact.
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
    scale = np.sqrt(np.diagonal(carried, axis1=1, axis2=2))
    unit = carried / scale[:, :, None] / scale[:, None, :] + 1e-9 * np.eye(SIDE)
    root = np.linalg.inv(np.linalg.cholesky(unit)) / scale[:, None, :]
    return np.asarray(np.where(blind[:, None, None], 0.0, root))
