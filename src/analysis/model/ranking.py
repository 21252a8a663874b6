"""Which effect would the data rather have: all candidates scored in one pass.

Linearised around the fit, each shot's own numbers and the fitted parameters projected out, a
candidate promises a fall in chi-squared of z^2 = g' M^-1 g and an amplitude of M^-1 g, exact for
small effects. The score is a signpost; the verdict is the refit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2 as chi2_distribution

from analysis.effects.effect import Effect
from analysis.model.fit import Fit
from analysis.model.linear import difference, linearise
from analysis.model.normal import BETA0_PRIOR_SIGMA, inverse, solve_blocks
from analysis.model.poses import PoseData
from analysis.model.prediction import predict

Floats = NDArray[np.float64]

LEAST_INFORMATION = 1e-6
"""A candidate with less than this share of its raw information left cannot be seen here."""
DRAWS = 2000
BEYOND_RANGE_SIGMAS = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """One effect's promise.

    Attributes
    ----------
    effect
        The effect.
    fall
        Promised fall of chi-squared, in units of the noise as it was found.
    amplitudes, sigmas
        Of each of its parameters, in their units, shape (parameters,).
    p_value
        Of the fall by itself.
    p_familywise
        Share of campaigns with nothing missing in which some candidate looks as good as this.
    seen
        False where these shots hold no information on it; nothing else then has a meaning.
    """

    effect: Effect
    fall: float
    amplitudes: Floats
    sigmas: Floats
    p_value: float
    p_familywise: float
    seen: bool

    @property
    def score(self) -> float:
        """Signed root of the fall for one parameter, the root for several."""
        sign = np.sign(self.amplitudes[0]) if len(self.amplitudes) == 1 else 1.0
        return float(sign * np.sqrt(self.fall))

    @property
    def plausible(self) -> bool:
        """Whether every amplitude lies in its believed range, its error allowed for."""
        return all(
            low - BEYOND_RANGE_SIGMAS * sigma <= value <= high + BEYOND_RANGE_SIGMAS * sigma
            for value, sigma, (low, high) in zip(
                self.amplitudes,
                self.sigmas,
                (p.plausible for p in self.effect.parameters),
                strict=True,
            )
        )


@dataclass(frozen=True, slots=True, eq=False)
class Ranking:
    """All candidates, the most promising first.

    Attributes
    ----------
    candidates
        In order of their falls; those that cannot be seen last.
    aliases
        Largest correlation between what two candidates do to the residuals, shape (K, K), in the
        same order: near 1 these shots cannot tell them apart.
    noise_scale
        Root of chi-squared per degree of freedom of the fit, by which sigmas were multiplied.
    """

    candidates: tuple[Candidate, ...]
    aliases: Floats
    noise_scale: float


def rank(data: PoseData, fit: Fit, effects: Sequence[Effect], seed: int = 0) -> Ranking:
    """Score every effect that is not in the fit yet.

    Parameters
    ----------
    seed
        Of the simulated scores behind `p_familywise`.
    """
    present = {active.effect.name for active in fit.theory.active}
    candidates = [effect for effect in effects if effect.name not in present]
    scale = float(np.sqrt(max(fit.chi2_per_dof, 1e-12)))
    if not candidates:
        return Ranking((), np.zeros((0, 0)), scale)
    columns, owners = _columns(data, fit, candidates)
    matrix, gradient, raw = _projected(data, fit, columns)
    visible = np.diag(matrix) > LEAST_INFORMATION * raw
    blocks = [np.flatnonzero((owners == k) & visible) for k in range(len(candidates))]
    falls = np.array([_fall(matrix, gradient, block) for block in blocks]) / scale**2
    sizes = np.array([block.size for block in blocks])
    p_values = np.where(sizes > 0, chi2_distribution.sf(falls, np.maximum(sizes, 1)), 1.0)
    familywise = _familywise(matrix, blocks, p_values, np.random.default_rng(seed))
    scored = [
        Candidate(
            effect=effect,
            fall=float(falls[k]),
            amplitudes=_amplitudes(matrix, gradient, blocks[k], len(effect.parameters)),
            sigmas=scale * _sigmas(matrix, blocks[k], len(effect.parameters)),
            p_value=float(p_values[k]),
            p_familywise=float(familywise[k]),
            seen=bool(sizes[k] == len(effect.parameters)),
        )
        for k, effect in enumerate(candidates)
    ]
    order = sorted(range(len(scored)), key=lambda k: (not scored[k].seen, -scored[k].fall))
    aliases = np.array([[_alias(matrix, blocks[i], blocks[j]) for j in order] for i in order])
    return Ranking(tuple(scored[k] for k in order), aliases, scale)


def _columns(
    data: PoseData, fit: Fit, candidates: Sequence[Effect]
) -> tuple[Floats, NDArray[np.intp]]:
    """Return the whitened derivatives (S, N, C) by all candidates' parameters, and their owners."""
    poses = predict(data, fit.states, fit.theory)
    columns, owners = [], []
    for k, effect in enumerate(candidates):
        theory = fit.theory.with_effect(effect)
        for j, parameter in enumerate(effect.parameters):
            vector = theory.vector
            vector[len(vector) - len(effect.parameters) + j] += parameter.step
            moved = predict(data, fit.states, theory.at(vector))
            columns.append(difference(data, poses, moved, parameter.step))
            owners.append(k)
    return np.stack(columns, axis=-1), np.array(owners, dtype=np.intp)


def _projected(data: PoseData, fit: Fit, columns: Floats) -> tuple[Floats, Floats, Floats]:
    """Return M and g of the candidates, all that is fitted projected out, and the raw diagonal."""
    line = linearise(data, fit.states, fit.theory)
    shared = np.concatenate([line.by_theory, columns], axis=2)
    by_state, by_shared = np.swapaxes(line.by_state, 1, 2), np.swapaxes(shared, 1, 2)
    coupling = by_state @ shared
    eliminated = solve_blocks(by_state @ line.by_state, coupling)
    matrix = (by_shared @ shared - np.swapaxes(coupling, 1, 2) @ eliminated).sum(axis=0)
    own = by_state @ line.residual[..., None]
    gradient = by_shared @ line.residual[..., None] - np.swapaxes(eliminated, 1, 2) @ own
    gradient = gradient.sum(axis=0)[:, 0]
    matrix[2, 2] += BETA0_PRIOR_SIGMA**-2
    fitted = len(fit.theory.names)
    inner = inverse(matrix[:fitted, :fitted]) @ matrix[:fitted, fitted:]
    reduced = matrix[fitted:, fitted:] - matrix[fitted:, :fitted] @ inner
    return (
        np.asarray(reduced),
        np.asarray(gradient[fitted:] - inner.T @ gradient[:fitted]),
        np.asarray((columns**2).sum(axis=(0, 1))),
    )


def _fall(matrix: Floats, gradient: Floats, block: NDArray[np.intp]) -> float:
    if block.size == 0:
        return 0.0
    return float(gradient[block] @ inverse(matrix[np.ix_(block, block)]) @ gradient[block])


def _amplitudes(matrix: Floats, gradient: Floats, block: NDArray[np.intp], count: int) -> Floats:
    if block.size < count:
        return np.full(count, np.nan)
    return np.asarray(inverse(matrix[np.ix_(block, block)]) @ gradient[block])


def _sigmas(matrix: Floats, block: NDArray[np.intp], count: int) -> Floats:
    if block.size < count:
        return np.full(count, np.nan)
    return np.asarray(np.sqrt(np.diag(inverse(matrix[np.ix_(block, block)]))))


def _alias(matrix: Floats, first: NDArray[np.intp], second: NDArray[np.intp]) -> float:
    """Return the largest canonical correlation between two blocks of columns."""
    if first.size == 0 or second.size == 0:
        return 0.0
    cross = matrix[np.ix_(first, second)]
    between = inverse(matrix[np.ix_(first, first)]) @ cross
    between = between @ inverse(matrix[np.ix_(second, second)]) @ cross.T
    return float(np.sqrt(np.clip(np.linalg.eigvals(between).real.max(), 0.0, 1.0)))


def _familywise(
    matrix: Floats,
    blocks: list[NDArray[np.intp]],
    p_values: Floats,
    rng: np.random.Generator,
) -> Floats:
    """Return for each p the share of chance campaigns whose smallest p is below it.

    Scores of a campaign with nothing missing are Gaussian with the correlation of the columns.
    """
    used = np.concatenate(blocks) if blocks else np.zeros(0, dtype=np.intp)
    if used.size == 0:
        return np.ones(len(blocks))
    values, vectors = np.linalg.eigh(matrix[np.ix_(used, used)])
    root = vectors * np.sqrt(np.clip(values, 0.0, None))
    draws = rng.standard_normal((DRAWS, used.size)) @ root.T
    smallest = np.ones(DRAWS)
    start = 0
    for block in blocks:
        if block.size == 0:
            continue
        own = draws[:, start : start + block.size]
        start += block.size
        solved = own @ inverse(matrix[np.ix_(block, block)])
        smallest = np.minimum(smallest, chi2_distribution.sf((own * solved).sum(1), block.size))
    # The chance counts itself, so that a share of zero is never claimed.
    return np.asarray([(1 + (smallest <= p).sum()) / (1 + DRAWS) for p in p_values])
