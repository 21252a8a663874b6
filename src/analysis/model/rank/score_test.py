"""Scores of candidates with everything that is fitted projected out.

M and g of all columns about a fit (model: one pass tells all). A candidate's fall of chi-squared is
g' M^-1 g over its own block, along what these shots can see of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from analysis import chi_squared
from analysis.arrays import Floats
from analysis.effects.effect import Effect
from analysis.model.data.stream import CampaignData
from analysis.model.data.tables import Data
from analysis.model.fitting.fit import Fit, parts_of
from analysis.model.fitting.normal import inverse, solve_blocks, with_prior
from analysis.model.fitting.slow_errors.field import FieldErrors, field_errors
from analysis.model.predict.columns import all_columns
from analysis.model.predict.comparison import Comparison, Snapshot, compare
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import Theory

Beside = Callable[[Data, Comparison, Snapshot], None]
"""What else is made of a pass over a campaign."""

LEAST_INFORMATION = 1e-6
"""A candidate with less than this share of its raw information left cannot be seen here."""
LEAST_DIRECTION = 1e-5
"""The same for a direction in a block: below it stands the rounding of differences."""
LEAST_FELT = 1e-9
"""A parameter whose whole plausible range moves chi-squared by less is only rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class Sums:
    """M (C, C) and g (C,) of C columns, what is fitted projected out.

    Attributes
    ----------
    matrix, gradient
        Summed over shots.
    raw
        Diagonal of M before anything was projected out, shape (C,).
    by_shot
        What each shot adds to g.
    """

    matrix: Floats
    gradient: Floats
    raw: Floats
    by_shot: ByShot


@dataclass(frozen=True, slots=True, eq=False)
class ByShot:
    """What each shot adds to the gradient of C columns, part by part.

    Attributes
    ----------
    pulls
        Of all columns before anything was projected out, those of what is fitted first; of the
        shots of one part each, shape (S, P + C).
    projection
        Takes them to the C columns, shape (P + C, C).
    """

    pulls: Iterable[Floats]
    projection: Floats

    def loudest(self, amplitudes: Floats, count: int) -> list[Loud]:
        """Return the shots with the largest part in each of several sums, the largest first.

        Parameters
        ----------
        amplitudes
            By which the columns are multiplied in each sum, shape (C, sums).
        """
        weights = self.projection @ amplitudes
        kept: list[list[tuple[float, int, Floats]]] = [[] for _ in range(amplitudes.shape[1])]
        start = 0
        for pulls in self.pulls:
            shares = pulls @ weights
            first = np.argsort(-shares, axis=0, kind="stable")[:count]
            for sum_, own in enumerate(kept):
                # Copies: a view would hold the whole part in memory.
                own += [
                    (float(shares[s, sum_]), start + int(s), pulls[s].copy())
                    for s in first[:, sum_]
                ]
                own[:] = sorted(own, key=lambda entry: -entry[0])[:count]
            start += len(pulls)
        return [
            Loud(
                tuple(shot for _, shot, _ in own),
                np.sum([pull for _, _, pull in own], axis=0) @ self.projection,
            )
            for own in kept
        ]


@dataclass(frozen=True, slots=True, eq=False)
class Loud:
    """The places of the loudest shots among all, and what they add to g together, shape (C,)."""

    places: tuple[int, ...]
    gradient: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """A candidate's own columns, and what these shots see of them.

    Attributes
    ----------
    columns
        Where they stand, shape (B,).
    whitening
        Takes scores to independent unit normals, shape (B, directions seen).
    one_sided
        Whether a fall counts only where the amplitude is positive.
    """

    columns: NDArray[np.intp]
    whitening: Floats
    one_sided: bool

    @property
    def freedom(self) -> int:
        """Directions that are seen."""
        return int(self.whitening.shape[1])

    def falls(self, scores: Floats) -> Floats:
        """Return the fall of chi-squared for scores (..., C), shape (...)."""
        along = scores[..., self.columns] @ self.whitening
        if self.one_sided:
            along = np.maximum(along, 0.0)
        return np.asarray((along**2).sum(axis=-1))

    def amplitudes(self, scores: Floats) -> Floats:
        """Return what the candidate's parameters would be for scores (C,), shape (B,)."""
        return np.asarray(self.whitening @ (self.whitening.T @ scores[self.columns]))

    def p_values(self, falls: Floats) -> Floats:
        """Return the chance of such falls when nothing is missing."""
        return chance_of_falls(falls, self.freedom, one_sided=self.one_sided)


def chance_of_falls(falls: Floats, freedom: int, *, one_sided: bool) -> Floats:
    """Return the chance that chi-squared falls so far when nothing is missing, shape (...).

    Half of a normal's where one sign of one amplitude counts, and none counts for the other.
    """
    falls = np.maximum(falls, 0.0)
    if one_sided:
        return np.where(falls > 0, ndtr(-np.sqrt(falls)), 1.0)
    return chi_squared.chance_of_more(falls, freedom)


def candidate_sums(
    data: CampaignData, fit: Fit, effects: Sequence[Effect], beside: Beside | None = None
) -> Sums:
    """Sum up the columns of all parameters of the effects, in their order, in one pass.

    Parameters
    ----------
    beside
        Called with every part of the pass, about the fit.
    """
    theory = fit.theory
    field = field_errors(data)
    fitted = len(theory.names) + field.count
    count = fitted + sum(len(effect.parameters) for effect in effects)
    matrix, raw, gradient = np.zeros((count, count)), np.zeros(count), np.zeros(count)
    pulls = data.keep(np.ndarray)
    for part, states in parts_of(data, fit):
        about = compare(part, states, theory)
        own, own_raw, pull = _piece(part, states, theory, effects, (*about, field))
        if beside is not None:
            beside(part, *about)
        matrix += own
        raw += own_raw
        gradient += pull.sum(axis=0)
        pulls.append(pull)
    centre, known = theory.prior
    strain, known = field.beside((theory.vector - centre) * known, known)
    matrix = with_prior(matrix, known)
    gradient[:fitted] -= strain
    inner = inverse(matrix[:fitted, :fitted]) @ matrix[:fitted, fitted:]
    ranges = [np.ptp(p.plausible) for effect in effects for p in effect.parameters]
    felt = raw[fitted:] * np.square(ranges) > LEAST_FELT
    return Sums(
        matrix=(matrix[fitted:, fitted:] - matrix[fitted:, :fitted] @ inner) * np.outer(felt, felt),
        gradient=(gradient[fitted:] - gradient[:fitted] @ inner) * felt,
        raw=raw[fitted:] * felt,
        by_shot=ByShot(pulls, np.concatenate([-inner, np.eye(count - fitted)]) * felt),
    )


def _piece(
    data: Data,
    states: ShotStates,
    theory: Theory,
    effects: Sequence[Effect],
    about: tuple[Comparison, Snapshot, FieldErrors],
) -> tuple[Floats, Floats, Floats]:
    """Return M, its raw diagonal and each shot's g, the shots' own numbers eliminated."""
    line, here, field = about
    given = field.columns(data)
    shared = all_columns(data, states, theory, line=line, here=here, effects=effects, given=given)
    by_state = np.swapaxes(line.by_state, 1, 2)
    coupling = by_state @ shared.against_flights(line)
    eliminated = solve_blocks(line.information, coupling)
    gram, flat = shared.whole_gram(line), (-1, coupling.shape[2])
    return (
        gram - eliminated.reshape(flat).T @ coupling.reshape(flat),
        np.diagonal(gram),
        shared.with_residual(line)
        - (np.swapaxes(eliminated, 1, 2) @ line.downhill[..., None])[..., 0],
    )


def block_of(sums: Sums, columns: NDArray[np.intp], *, one_sided: bool) -> Block:
    """Return the directions of a candidate's columns that these shots can see."""
    root = np.sqrt(np.maximum(sums.raw[columns], 1e-300))
    own = sums.matrix[np.ix_(columns, columns)] / root[:, None] / root[None, :]
    values, vectors = np.linalg.eigh(own)
    least = LEAST_INFORMATION if len(columns) == 1 else LEAST_DIRECTION
    seen = values > least
    whitening = vectors[:, seen] / np.sqrt(values[seen]) / root[:, None]
    if len(columns) == 1:
        whitening = np.abs(whitening)
    return Block(columns, np.asarray(whitening), one_sided)
