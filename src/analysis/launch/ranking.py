"""Score tests of all effects of the launch that are not in the fit, in one pass.

The score test of `model.ranking`, on launches whitened with measurement and scatter. An effect
that is in the fit is scored by what taking it out would cost, so that friction, which is in by
default, has its score too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.effects.effect import LaunchEffect
from analysis.launch.compared import compare
from analysis.launch.muzzle import LAW_NAMES
from analysis.launch.result import LaunchFit
from analysis.launch.theory import LaunchTheory
from analysis.model.fitting.normal import inverse
from analysis.model.rank.candidate import believed
from analysis.model.rank.ranking import alias_matrix, smallest_by_chance
from analysis.model.rank.score_test import Block, ByShot, Sums, block_of

LEAST_RAW = 1e-100
"""Information of a column that does nothing at all, for divisions by it."""


@dataclass(frozen=True, slots=True, eq=False)
class LaunchCandidate:
    """Score test of one launch effect; fields as those of `model.rank.candidate.Candidate`.

    Attributes
    ----------
    effect
        The effect.
    delta_chi2
        Delta chi-squared: predicted by the score test, or reached if the effect is in the fit.
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
    delta_chi2: float
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
        return float(sign * np.sqrt(self.delta_chi2))

    @property
    def plausible(self) -> bool:
        """Whether every amplitude lies in its plausible range, its error allowed for."""
        return believed(self.effect, self.amplitudes, self.sigmas)


@dataclass(frozen=True, slots=True, eq=False)
class LaunchRanking:
    """Effects of the launch: the most promising first; then those in the fit; then those unseen.

    `aliases` holds the largest correlation between what two of them do, shape (K, K), in the same
    order: near 1 these settings cannot distinguish them.
    """

    candidates: tuple[LaunchCandidate, ...]
    aliases: Floats


def rank_launch(launch: LaunchFit, effects: Sequence[LaunchEffect], seed: int = 0) -> LaunchRanking:
    """Score every effect, fitted or not.

    The predicted delta chi-squared is exact for small effects. The scatter is that of the fit; a
    missing effect enlarges it, so that a large delta chi-squared is larger than predicted.

    Parameters
    ----------
    seed
        Of the simulated scores behind `p_familywise`.
    """
    fitted = {active.effect.name for active in launch.theory.active}
    sums = _sums(launch, effects)
    blocks = _blocks(sums, effects)
    falls = [float(block.falls(sums.gradient)) for block in blocks]
    p_values = [float(b.p_values(np.array(f))) for b, f in zip(blocks, falls, strict=True)]
    alike, rng = [1.0] * len(blocks), np.random.default_rng(seed)
    smallest = smallest_by_chance(sums.matrix, blocks, alike, rng)
    candidates = [
        LaunchCandidate(
            effect=effect,
            delta_chi2=delta_chi2,
            amplitudes=block.whitening @ block.whitening.T @ sums.gradient[block.columns],
            sigmas=np.sqrt((block.whitening**2).sum(axis=1)),
            p_value=p,
            # The chance counts itself, so that a share of zero is never claimed.
            p_familywise=float((1 + (smallest <= p).sum()) / (1 + len(smallest))),
            seen=block.freedom == len(effect.parameters),
            fitted=effect.name in fitted,
        )
        for effect, block, delta_chi2, p in zip(effects, blocks, falls, p_values, strict=True)
    ]
    order = sorted(
        range(len(blocks)),
        key=lambda k: (not candidates[k].seen, candidates[k].fitted, -candidates[k].delta_chi2),
    )
    aliases = alias_matrix(sums.matrix, [blocks[k] for k in order])
    return LaunchRanking(tuple(candidates[k] for k in order), aliases)


def _blocks(sums: Sums, effects: Sequence[LaunchEffect]) -> list[Block]:
    blocks, start = [], 0
    for effect in effects:
        stop = start + len(effect.parameters)
        one_sided = stop == start + 1 and effect.parameters[0].one_sided
        blocks.append(block_of(sums, np.arange(start, stop), one_sided=one_sided))
        start = stop
    return blocks


def _sums(launch: LaunchFit, effects: Sequence[LaunchEffect]) -> Sums:
    """Sum up the columns of all effects, nuisance parameters projected out of each.

    Of an effect in the fit, g is that at its off value: its amplitude is then what was fitted.
    """
    theory = launch.theory
    for effect in effects:
        if effect.name not in {active.effect.name for active in theory.active}:
            theory = theory.with_effect(effect)
    compared = compare(theory, launch.settings, launch.touches)
    residual, derivative = compared.whitened(launch.scatter)
    flat = derivative.reshape(-1, derivative.shape[-1])
    places = _places(theory)
    fitted = len(launch.theory.names)
    left, by_number, held = [], [], []
    for effect in effects:
        own = places[effect.name]
        free, pull = _alone(flat, theory, own, np.setdiff1d(np.arange(fitted), own))
        there = flat[:, own] @ (theory.vector[own] - effect.off)
        left.append(free)
        by_number.append(free * (residual.reshape(-1) + there)[:, None])
        held.append(pull)
    columns, pulls = np.concatenate(left, axis=1), np.concatenate(by_number, axis=1)
    by_shot = pulls.reshape(len(residual), -1, columns.shape[1]).sum(axis=1)
    owned = np.concatenate([places[effect.name] for effect in effects])
    return Sums(
        matrix=columns.T @ columns,
        gradient=by_shot.sum(axis=0) + np.concatenate(held),
        raw=np.maximum((flat[:, owned] ** 2).sum(axis=0), LEAST_RAW),
        by_shot=ByShot([by_shot], np.eye(by_shot.shape[1])),
    )


def _alone(
    flat: Floats, theory: LaunchTheory, own: NDArray[np.intp], others: NDArray[np.intp]
) -> tuple[Floats, Floats]:
    """Return the columns `own` less what the others do, and what the others' prior adds to g."""
    centre, width = (part[others] for part in theory.prior)
    rest = flat[:, others]
    share = inverse(rest.T @ rest + np.diag(width**-2)) @ rest.T @ flat[:, own]
    return flat[:, own] - rest @ share, share.T @ ((theory.vector[others] - centre) / width**2)


def _places(theory: LaunchTheory) -> dict[str, NDArray[np.intp]]:
    """Return the indices of each effect's parameters in the theory's vector."""
    places, start = {}, len(LAW_NAMES)
    for active in theory.active:
        stop = start + len(active.values)
        places[active.effect.name] = np.arange(start, stop)
        start = stop
    return places
