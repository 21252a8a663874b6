"""How far a rival theory stays from what the true one would show, after it was refitted.

T-criterion (A. C. Atkinson and V. V. Fedorov, Biometrika 62, 57 (1975)): chi-squared of the rival
against poses that the truth foretells, each shot's own numbers and all that the shots share fitted
anew for every design. About the rival's fit it is quadratic in what the shots share, so that a
design is a sum over shots of c, g and M: c - g' M^-1 g.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import normal_equations
from analysis.model.fitting.normal import NormalEquations, inverse, solve_blocks, with_prior
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import Theory

_ROUNDS = 12
_SHARES = (1.0, 0.5, 0.2, 0.05)
_ENOUGH = 1e-2
_TROUBLE = 4.0
"""A shot whose chi-squared grows by more than this is better left where it was."""


@dataclass(frozen=True, slots=True, eq=False)
class Design:
    """Sums of one design, or of several at once (..., leading axes).

    Attributes
    ----------
    left
        Chi-squared where the shots' own numbers are at their best, shape (...,).
    gradient, matrix
        Downhill by the P shared parameters, (..., P), and their information, (..., P, P).
    """

    left: Floats
    gradient: Floats
    matrix: Floats

    def plus(self, other: Design, count: Floats | float = 1.0) -> Design:
        """Return the design with `count` of another added."""
        n = np.asarray(count)
        return Design(
            self.left + n * other.left,
            self.gradient + n[..., None] * other.gradient,
            self.matrix + n[..., None, None] * other.matrix,
        )

    def total(self, counts: Floats) -> Design:
        """Return the sum of designs (K,), each taken so many times, (K,)."""
        return Design(
            np.asarray(counts @ self.left),
            np.asarray(counts @ self.gradient),
            np.asarray(np.tensordot(counts, self.matrix, 1)),
        )

    def at(self, index: int) -> Design:
        """Return one of several."""
        return Design(self.left[index], self.gradient[index], self.matrix[index])

    @property
    def apart(self) -> Floats:
        """Chi-squared that is left after the refit of what the shots share, shape (...,)."""
        scale = np.sqrt(np.maximum(np.diagonal(self.matrix, axis1=-2, axis2=-1), 1e-300))
        scaled = self.matrix / scale[..., :, None] / scale[..., None, :]
        index = np.arange(scaled.shape[-1])
        scaled[..., index, index] += 1e-10
        right = self.gradient / scale
        solved = np.linalg.solve(scaled, right[..., None])[..., 0]
        return np.asarray(np.maximum(self.left - (right * solved).sum(axis=-1), 0.0))


def by_shot(data: PoseData, states: ShotStates, theory: Theory) -> Design:
    """Return what each shot adds about a theory, its own numbers eliminated, (S,) designs."""
    return _eliminated(normal_equations(data, states, theory))


def refitted(
    data: PoseData, states: ShotStates, theory: Theory, weights: Floats
) -> tuple[ShotStates, Theory]:
    """Fit a theory to shots that count by weights (S,); every shot's own numbers are fitted.

    Parameters
    ----------
    states
        Where the fit starts.
    """
    sums = normal_equations(data, states, theory)
    for _ in range(_ROUNDS):
        design = _eliminated(sums)
        matrix = with_prior(design.total(weights).matrix, theory.prior[1])
        step = inverse(matrix) @ (weights @ design.gradient)
        before = float(weights @ design.left)
        moved, tried = theory, sums
        new = states
        for share in _SHARES:
            moved = theory.at(theory.vector + share * step)
            new, tried = _own_step(data, states, sums, moved, share * step)
            after = float(weights @ _eliminated(tried).left)
            if after <= before + _ENOUGH:
                break
        else:
            return states, theory
        states, theory, sums = new, moved, tried
        if before - after < _ENOUGH:
            break
    return states, theory


def _own_step(
    data: PoseData, states: ShotStates, sums: NormalEquations, theory: Theory, step: Floats
) -> tuple[ShotStates, NormalEquations]:
    """Move every shot's own numbers along with what is shared; one that gains nothing stays."""
    right = sums.state_gradient - sums.coupling @ step
    new = states.moved(solve_blocks(sums.states, right[..., None])[..., 0])
    tried = normal_equations(data, new, theory)
    if (tried.chi2 <= _TROUBLE * (sums.chi2 + 1.0)).all():
        return new, tried
    stayed = normal_equations(data, states, theory)
    better = tried.chi2 <= stayed.chi2
    return states.chosen(new, better), stayed.chosen(tried, better)


def _eliminated(sums: NormalEquations) -> Design:
    matrix, gradient = sums.reduced_by_shot()
    own = solve_blocks(sums.states, sums.state_gradient[..., None])[..., 0]
    return Design(sums.chi2 - (own * sums.state_gradient).sum(axis=1), gradient, matrix)
