"""Which effect of the launch the touches ask for: all candidates scored in one pass.

The score test of `model.ranking`, on launches whitened with measurement and scatter. An effect
that is in the fit is scored by what taking it out would cost, so that friction, which is in by
default, has its score too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2 as chi2_distribution

from analysis.effects.effect import LaunchEffect
from analysis.launch.compared import compare
from analysis.launch.muzzle import LAW_NAMES
from analysis.launch.result import LaunchFit
from analysis.launch.theory import LaunchTheory
from analysis.model.normal import inverse
from analysis.model.ranking import BEYOND_RANGE_SIGMAS

Floats = NDArray[np.float64]

LEAST_INFORMATION = 1e-6
DRAWS = 2000


@dataclass(frozen=True, slots=True, eq=False)
class LaunchCandidate:
    """One effect's promise; fields as those of `model.ranking.Candidate`.

    Attributes
    ----------
    effect
        The effect.
    fall
        Fall of chi-squared that it promises, or has brought if it is in the fit.
    amplitudes, sigmas
        Of each of its parameters, in their units, shape (parameters,).
    p_value
        Of the fall by itself.
    p_familywise
        Share of campaigns with nothing missing in which some effect looks as good as this.
    seen
        False where these settings hold no information on it; nothing else then has a meaning.
    fitted
        It is in the fit.
    """

    effect: LaunchEffect
    fall: float
    amplitudes: Floats
    sigmas: Floats
    p_value: float
    p_familywise: float
    seen: bool
    fitted: bool

    @property
    def score(self) -> float:
        """Signed root of the fall for one parameter, the root for several."""
        sign = np.sign(self.amplitudes[0]) if len(self.amplitudes) == 1 else 1.0
        return float(sign * np.sqrt(self.fall))

    @property
    def plausible(self) -> bool:
        """Whether every amplitude lies in its believed range, its error allowed for."""
        bounds = np.array([parameter.plausible for parameter in self.effect.parameters])
        spare = BEYOND_RANGE_SIGMAS * self.sigmas
        within = (bounds[:, 0] - spare <= self.amplitudes) & (
            self.amplitudes <= bounds[:, 1] + spare
        )
        return bool(within.all())


@dataclass(frozen=True, slots=True, eq=False)
class LaunchRanking:
    """Effects of the launch: the most promising first; then those in the fit; then those unseen.

    `aliases` holds the largest correlation between what two of them do, shape (K, K), in the same
    order: near 1 these settings cannot tell them apart.
    """

    candidates: tuple[LaunchCandidate, ...]
    aliases: Floats


@dataclass(frozen=True, slots=True, eq=False)
class _Score:
    """One effect: what its parameters add that nothing else fitted does.

    columns: whitened derivatives less their projection on the other fitted parameters, (N, k).
    amplitudes: their least-squares values, with covariance, none where nothing is seen.
    """

    columns: Floats
    amplitudes: Floats
    covariance: Floats
    fall: float
    seen: bool


def rank_launch(launch: LaunchFit, effects: Sequence[LaunchEffect], seed: int = 0) -> LaunchRanking:
    """Score every effect, fitted or not.

    The promised fall of chi-squared is exact for small effects. The scatter is held as the fit has
    it; a missing effect has swollen it, so that a large fall is larger than promised.

    Parameters
    ----------
    seed
        Of the simulated scores behind `p_familywise`.
    """
    theory = launch.theory
    fitted = {active.effect.name for active in theory.active}
    for effect in effects:
        if effect.name not in fitted:
            theory = theory.with_effect(effect)
    compared = compare(theory, launch.settings, launch.touches)
    residual, derivative = compared.whitened(launch.scatter)
    flat = derivative.reshape(-1, derivative.shape[-1])
    scores = {
        name: _score(residual.reshape(-1), flat, theory, columns, len(launch.theory.names))
        for name, columns in _columns(theory).items()
    }
    named = {effect.name: effect for effect in effects}
    scores = {name: score for name, score in scores.items() if name in named}
    p_values = {name: _p_value(score) for name, score in scores.items()}
    smallest = _smallest_by_chance(list(scores.values()), np.random.default_rng(seed))
    candidates = [
        LaunchCandidate(
            effect=named[name],
            fall=score.fall,
            amplitudes=score.amplitudes,
            sigmas=np.sqrt(np.diag(score.covariance)),
            p_value=p_values[name],
            # The chance counts itself, so that a share of zero is never claimed.
            p_familywise=float((1 + (smallest <= p_values[name]).sum()) / (1 + DRAWS)),
            seen=score.seen,
            fitted=name in fitted,
        )
        for name, score in scores.items()
    ]
    candidates.sort(key=lambda one: (not one.seen, one.fitted, -one.fall))
    ordered = [scores[candidate.effect.name] for candidate in candidates]
    aliases = np.array([[_alias(first, second) for second in ordered] for first in ordered])
    return LaunchRanking(tuple(candidates), aliases)


def _columns(theory: LaunchTheory) -> dict[str, NDArray[np.intp]]:
    """Return where the parameters of each effect stand in the theory's vector."""
    columns, start = {}, len(LAW_NAMES)
    for active in theory.active:
        stop = start + len(active.values)
        columns[active.effect.name] = np.arange(start, stop)
        start = stop
    return columns


def _score(
    residual: Floats, flat: Floats, theory: LaunchTheory, own: NDArray[np.intp], fitted: int
) -> _Score:
    """Score the parameters `own` of an effect against all others among the first `fitted`."""
    others = np.setdiff1d(np.arange(fitted), own)
    centre, width = (part[others] for part in theory.prior)
    rest, columns = flat[:, others], flat[:, own]
    matrix = rest.T @ rest + np.diag(width**-2)
    pull = rest.T @ residual - (theory.vector[others] - centre) / width**2
    share = inverse(matrix) @ (rest.T @ columns)
    left = columns - rest @ share
    information = left.T @ columns
    raw = (columns**2).sum(axis=0)
    if (np.diag(information) <= LEAST_INFORMATION * raw).any():
        nothing = np.full(len(own), np.nan)
        return _Score(left, nothing, np.diag(nothing), 0.0, seen=False)
    covariance = inverse(information)
    gradient = columns.T @ residual - share.T @ pull
    off = np.concatenate([active.effect.off for active in theory.active])
    amplitudes = theory.vector[own] - off[own - len(LAW_NAMES)] + covariance @ gradient
    fall = float(amplitudes @ information @ amplitudes)
    amplitudes = amplitudes + off[own - len(LAW_NAMES)]
    return _Score(left, amplitudes, covariance, fall, seen=True)


def _p_value(score: _Score) -> float:
    return float(chi2_distribution.sf(score.fall, len(score.amplitudes))) if score.seen else 1.0


def _smallest_by_chance(scores: Sequence[_Score], rng: np.random.Generator) -> Floats:
    """Return the smallest p of each of many campaigns with nothing missing, shape (DRAWS,).

    Scores are then Gaussian, with the correlation of the columns.
    """
    smallest = np.ones(DRAWS)
    seen = [score for score in scores if score.seen]
    if not seen:
        return smallest
    columns = np.concatenate([score.columns for score in seen], axis=1)
    values, vectors = np.linalg.eigh(columns.T @ columns)
    draws = rng.standard_normal((DRAWS, len(values))) @ (vectors * np.sqrt(values.clip(0.0))).T
    start = 0
    for score in seen:
        size = len(score.amplitudes)
        own = draws[:, start : start + size]
        start += size
        fall = np.einsum("di,ij,dj->d", own, score.covariance, own)
        smallest = np.minimum(smallest, chi2_distribution.sf(fall, size))
    return smallest


def _alias(first: _Score, second: _Score) -> float:
    """Return the largest canonical correlation between what two effects do."""
    if not (first.seen and second.seen):
        return 0.0
    cross = first.columns.T @ second.columns
    between = inverse(first.columns.T @ first.columns) @ cross
    between = between @ inverse(second.columns.T @ second.columns) @ cross.T
    return float(np.sqrt(np.clip(np.linalg.eigvals(between).real.max(), 0.0, 1.0)))
