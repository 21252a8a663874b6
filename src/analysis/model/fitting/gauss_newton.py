"""Gauss-Newton on a campaign in parts: each shot's own numbers eliminated, what is shared stepped.

Each shot's 24 numbers enter only its own residuals, so their block is eliminated shot by shot
(Schur complement): M = C - B' A^-1 B, g = c - B' A^-1 a. The sums over shots are all that the joint
step s needs; a shot's own step is then A^-1 a - A^-1 B s.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.model.data.parts import Keeper, Kept
from analysis.model.data.stream import CampaignData, beside
from analysis.model.data.tables import Data
from analysis.model.fitting.normal import (
    NormalEquations,
    inverse,
    prior_cost,
    solve_blocks,
    sums_of,
    with_prior,
)
from analysis.model.fitting.own_fit import own_states
from analysis.model.predict.columns import theory_columns
from analysis.model.predict.comparison import compare
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import Theory

Summed = tuple[ShotStates, NormalEquations]
"""States of the shots of a part, and the sums about them."""

LARGEST_LAW_STEP = np.array([0.1, 0.05, 0.3])
JOINT_ITERATIONS = 30
LITTLE_FALL, NO_FALL = 0.1, 0.01
"""Two steps that bring little, or one that brings nothing, are the last ones; a step whose expected
drop is nothing is not taken."""
TRUSTED = 2.0
"""Times its expected drop a fit may come down that has not begun far away."""
ROUGH = 0.01
"""Share of all that steps have brought, below which two in a row end a rough fit."""
NEGLIGIBLE = 1e-3
"""Share of what a theory leaves unexplained."""
SHARES = (1.0, 0.4, 0.1)
WORSE, MOST_AT_CORNER = 0.5, 0.25
"""Rise of a shot's chi-squared that tells of a corner; where many rise, a step is too long."""


@dataclass(frozen=True, slots=True, eq=False)
class Stand:
    """Where the shots of one part stand, and which way is down.

    Attributes
    ----------
    states
        The shots' own numbers.
    chi2
        Shape (S,).
    downhill
        A^-1 a, shape (S, 24).
    coupled
        A^-1 B, shape (S, 24, P).
    """

    states: ShotStates
    chi2: Floats
    downhill: Floats
    coupled: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """A campaign linearised about a theory.

    Attributes
    ----------
    matrix, gradient
        M (P, P) and g (P,), the prior in.
    cost
        Chi-squared and what the prior adds to it.
    own_drop
        By how much the shots' own numbers alone could lower it, to first order.
    stands
        Of the shots, part by part.
    """

    theory: Theory
    matrix: Floats
    gradient: Floats
    cost: float
    own_drop: float
    stands: Kept[Stand]

    def step(self) -> Floats:
        """Return the joint step, shape (P,), no longer than the law is believed to be linear."""
        step = self._within()
        return np.asarray(step / max(1.0, float(np.abs(step[:3] / LARGEST_LAW_STEP).max())))

    def _within(self) -> Floats:
        """Return the step to the minimum that leaves no parameter outside its possible range.

        One that would leave it goes as far as its bound, and the others step about that.
        """
        here, (least, largest) = self.theory.vector, self.theory.possible
        step, bound = np.zeros(len(here)), np.zeros(len(here), dtype=np.bool_)
        for _ in here:
            free = ~bound
            pull = self.gradient[free] - self.matrix[np.ix_(free, bound)] @ step[bound]
            step[free] = inverse(self.matrix[np.ix_(free, free)]) @ pull
            to = np.clip(here + step, least, largest)
            beyond = free & (to != here + step)
            if not beyond.any():
                break
            step[beyond] = (to - here)[beyond]
            bound |= beyond
        return step

    def reach(self) -> float:
        """Return by how much the cost would be lowered at best, if the law were linear."""
        return self.expected_drop(self._within())

    def expected_drop(self, step: Floats) -> float:
        """Return by how much a joint step and the shots' own would lower the cost, if linear."""
        return float(self.gradient @ step) + self.own_drop


@dataclass(frozen=True, slots=True)
class Purpose:
    """How far a fit is to be followed.

    Attributes
    ----------
    beat
        Cost of another fit: once this one is not expected to come below it, it is left.
    enough
        Cost below which it is known all that is asked: the fit is left there.
    roughly
        Whether it is enough to see how far it comes down: steps that bring less than a hundredth
        of what all have brought are the last then.
    trusted
        Times its expected drop a fit may come down.
    """

    beat: float = np.inf
    enough: float = -np.inf
    roughly: bool = False
    trusted: float = TRUSTED


TO_THE_END = Purpose()


def descended(
    data: CampaignData, place: Place, freedom: Floats, purpose: Purpose = TO_THE_END
) -> tuple[Place, bool]:
    """Go down to the minimum of chi-squared.

    Parameters
    ----------
    data
        Gone over once for each step that is tried.
    freedom
        Measured numbers of each shot less its own, shape (S,).

    Returns
    -------
    The last place, and whether the last steps lowered chi-squared by less than what matters.
    """
    begun, before = place.cost, np.inf
    for _ in range(JOINT_ITERATIONS):
        if place.cost - purpose.trusted * place.reach() > purpose.beat:
            return place, False
        if place.cost < purpose.enough:
            return place, False
        lower = _searched(data, place)
        fall = place.cost - lower.cost
        if max(fall, before) < _little(lower, freedom) or fall < NO_FALL:
            return lower, True
        if purpose.roughly and max(fall, before) < ROUGH * (begun - lower.cost):
            return lower, False
        place, before = lower, fall
    return place, False


def _little(place: Place, freedom: Floats) -> float:
    """Return which fall of chi-squared matters no more.

    A wrong law has corners in most shots, along which it can creep down for long. How much it
    leaves unexplained is judged by the shot in the middle: few bad ones tell nothing of it.
    """
    chi2 = np.concatenate([stand.chi2 for stand in place.stands])
    left = float(np.median(chi2 / freedom)) - 1.0
    return max(LITTLE_FALL, NEGLIGIBLE * left * float(freedom.sum()))


def linearised(parts: Iterable[Summed], theory: Theory, keep: Keeper) -> Place:
    """Add up parts that were linearised about a theory."""
    count = len(theory.vector)
    matrix, gradient = np.zeros((count, count)), np.zeros(count)
    cost, expected_drop = prior_cost(theory), 0.0
    stands = keep(Stand)
    for states, sums in parts:
        right = np.concatenate([sums.state_gradient[..., None], sums.coupling], axis=2)
        solved = solve_blocks(sums.states, right)
        taken = (np.swapaxes(sums.coupling, 1, 2) @ solved).sum(axis=0)
        matrix += sums.shared.sum(axis=0) - taken[:, 1:]
        gradient += sums.shared_gradient.sum(axis=0) - taken[:, 0]
        cost += float(sums.chi2.sum())
        expected_drop += float((sums.state_gradient * solved[..., 0]).sum())
        stands.append(Stand(states, sums.chi2, solved[..., 0], solved[..., 1:]))
    centre, information = theory.prior
    gradient -= (theory.vector - centre) * information
    return Place(theory, with_prior(matrix, information), gradient, cost, expected_drop, stands)


def summed(data: Data, states: ShotStates, theory: Theory) -> Summed:
    """Linearise the shots of one part about states and theory, and sum up by shot."""
    line, here = compare(data, states, theory)
    return states, sums_of(line, theory_columns(data, states, theory, line, here))


def _searched(data: CampaignData, place: Place) -> Place:
    """Take the longest share of the joint step that lowers chi-squared; none: stay."""
    step = place.step()
    if place.expected_drop(step) < NO_FALL:
        return place
    for share in SHARES:
        moved = place.theory.at(place.theory.vector + share * step)
        tried = linearised(_stepped(data, place, (step, share), moved), moved, data.keep)
        if tried.cost < place.cost:
            return tried
    if any(_at_corner(*both).any() for both in _both(place, tried)):
        tried = linearised(_held_back(data, place, tried), moved, data.keep)
    return tried if tried.cost < place.cost else place


def _stepped(
    data: CampaignData, place: Place, stride: tuple[Floats, float], theory: Theory
) -> Iterator[Summed]:
    step, share = stride
    for part, stand in beside(data, place.stands):
        own = share * (stand.downhill - stand.coupled @ step)
        yield summed(part, stand.states.moved(own), theory)


def _held_back(data: CampaignData, place: Place, tried: Place) -> Iterator[Summed]:
    """Fit the few shots that a step makes worse by themselves, from where they stood.

    Where rolling turns to sliding the law has a corner, and its slopes hold on one side only. A
    single shot that lies there would hold up the step of all.
    """
    for part, (stand, moved) in beside(data, _both(place, tried)):
        worse, states = _at_corner(stand, moved), moved.states
        if worse.any():
            own = own_states(part.of_shots(worse), stand.states.of_shots(worse), tried.theory)
            states = states.replaced(worse, own)
        yield summed(part, states, tried.theory)


def _both(place: Place, tried: Place) -> Iterator[tuple[Stand, Stand]]:
    return zip(place.stands, tried.stands, strict=True)


def _at_corner(stand: Stand, moved: Stand) -> NDArray[np.bool_]:
    """Return which shots a step has made worse, shape (S,); none if it is many."""
    worse = moved.chi2 > stand.chi2 + WORSE
    return np.asarray(worse & (worse.mean() < MOST_AT_CORNER))
