"""Fitting a campaign: every shot's own numbers eliminated, what all shots share fitted jointly.

Gauss-Newton on chi-squared. Each shot's 24 numbers enter only its own residuals, so their block
is eliminated shot by shot (Schur complement): M = C - B' A^-1 B, g = c - B' A^-1 a. The sums over
shots are all that the joint step needs.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from analysis.collision.operator import WaltonLaw
from analysis.model.columns import no_columns, theory_columns
from analysis.model.comparison import compare
from analysis.model.normal import (
    LAW_PRIOR,
    NormalEquations,
    inverse,
    prior_cost,
    shot_steps,
    solve_blocks,
    sums_of,
)
from analysis.model.start import first_states
from analysis.model.state import ShotStates
from analysis.model.tables import Data
from analysis.model.theory import Theory
from analysis.model.unseen import fitted_numbers
from analysis.quantity import Quantity

Floats = NDArray[np.float64]

START = WaltonLaw(*LAW_PRIOR)
LARGEST_LAW_STEP = np.array([0.1, 0.05, 0.3])
SHOT_ROUNDS, SHOT_ITERATIONS, JOINT_ITERATIONS = 3, 4, 30
"""A round goes on with the shots that the round before has not brought to rest."""
ENOUGH_FALL = 0.01
ROUGHLY = 0.5
"""Of chi-squared of a shot by itself: what all shots share is to come."""
SHOTS_AT_ONCE = 128
SHARES = (1.0, 0.5, 0.2, 0.05)


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """A fitted campaign.

    Attributes
    ----------
    theory
        Law and effects at the minimum.
    states
        The shots' own numbers.
    covariance
        Of the theory's parameters, as the stated sigmas give it, shape (P, P).
    chi2, residuals
        Total chi-squared and number of residuals that enter it.
    shot_chi2, shot_residuals
        By shot, shape (S,).
    own_numbers
        How many of each shot's own numbers the data determine, shape (S,).
    converged
        Whether the last step lowered chi-squared by less than what matters.
    scatter
        Parameters of noise that the data were given besides their sigmas.
    """

    theory: Theory
    states: ShotStates
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


def fit_campaign(data: Data, theory: Theory | None = None, start: Fit | None = None) -> Fit:
    """Fit what all shots share together with every shot's own numbers.

    Parameters
    ----------
    theory
        Law and effects to start from; None: the hard-sphere operator alone.
    start
        An earlier fit of the same data whose states are taken over. Without one each shot is
        first fitted by itself (Levenberg-Marquardt, damped shot by shot, so that one in trouble
        does not slow the others).
    """
    present = Theory(START) if theory is None else theory
    own = None if start is None else start.states
    states = own or _fit_shots(data, first_states(data), present)
    sums = normal_equations(data, states, present)
    converged = False
    for _ in range(JOINT_ITERATIONS):
        before = _cost(sums, present)
        present, states, sums = _search(data, states, present, sums)
        if before - _cost(sums, present) < ENOUGH_FALL:
            converged = True
            break
    matrix, _ = sums.reduced(present)
    measured = data.measured.reshape(len(sums.chi2), -1).sum(axis=1)
    return Fit(
        theory=present,
        states=states,
        covariance=inverse(matrix),
        chi2=float(sums.chi2.sum()),
        residuals=int(measured.sum()),
        shot_chi2=sums.chi2,
        shot_residuals=measured,
        own_numbers=fitted_numbers(data),
        converged=converged,
        scatter=start.scatter if start is not None and data.jitter_s > 0 else {},
    )


def normal_equations(data: Data, states: ShotStates, theory: Theory) -> NormalEquations:
    """Linearise about states and theory and sum up by shot."""

    def sums(part: Data, own: ShotStates) -> NormalEquations:
        line, here = compare(part, own, theory)
        return sums_of(line, theory_columns(part, own, theory, line, here))

    return NormalEquations.joined([sums(*part) for part in parts_of(data, states)])


def parts_of(data: Data, states: ShotStates) -> Iterator[tuple[Data, ShotStates]]:
    """Return data and states of so many shots at a time as a processor's cache holds."""
    for start in range(0, len(data.shots), SHOTS_AT_ONCE):
        some = slice(start, start + SHOTS_AT_ONCE)
        yield data.part(some), states.of_shots(some)


def _search(
    data: Data, states: ShotStates, theory: Theory, sums: NormalEquations
) -> tuple[Theory, ShotStates, NormalEquations]:
    """Take the longest share of the joint step that lowers chi-squared; none: stay."""
    matrix, gradient = sums.reduced(theory)
    step = inverse(matrix) @ gradient
    step = step / max(1.0, float(np.abs(step[:3] / LARGEST_LAW_STEP).max()))
    right = sums.state_gradient - sums.coupling @ step
    own = solve_blocks(sums.states, right[..., None])[..., 0]
    for share in SHARES:
        moved, new = theory.at(theory.vector + share * step), states.moved(share * own)
        tried = normal_equations(data, new, moved)
        if _cost(tried, moved) < _cost(sums, theory):
            return moved, new, tried
    return theory, states, sums


def _cost(sums: NormalEquations, theory: Theory) -> float:
    return float(sums.chi2.sum()) + prior_cost(theory)


def _fit_shots(data: Data, states: ShotStates, theory: Theory) -> ShotStates:
    """Fit every shot by itself at a fixed theory."""
    return ShotStates.joined([_fit_part(*part, theory) for part in parts_of(data, states)])


def _fit_part(data: Data, states: ShotStates, theory: Theory) -> ShotStates:
    left = np.ones(len(states.time_s), dtype=np.bool_)
    for _ in range(SHOT_ROUNDS):
        own, done = _fit_some(data.of_shots(left), states.of_shots(left), theory)
        states = states.replaced(left, own)
        left[left] = ~done
        if not left.any():
            break
    return states


def _fit_some(
    data: Data, states: ShotStates, theory: Theory
) -> tuple[ShotStates, NDArray[np.bool_]]:
    """Take a few damped steps with every shot; return their states, and which are done, (S,)."""
    damping = np.full(len(states.time_s), 1e-3)
    sums = _own_equations(data, states, theory)
    done = np.zeros(len(damping), dtype=np.bool_)
    for _ in range(SHOT_ITERATIONS):
        new = states.moved(shot_steps(sums, damping))
        tried = _own_equations(data, new, theory)
        better = tried.chi2 < sums.chi2
        done = np.abs(sums.chi2 - tried.chi2) < ROUGHLY
        states, sums = states.chosen(new, better), sums.chosen(tried, better)
        damping = np.clip(np.where(better, damping * 0.1, damping * 10.0), 1e-12, 1e6)
        if done.all():
            break
    return states, done


def _own_equations(data: Data, states: ShotStates, theory: Theory) -> NormalEquations:
    line, _ = compare(data, states, theory)
    return sums_of(line, no_columns(line))
