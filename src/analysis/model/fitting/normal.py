"""Normal equations of a campaign, shot by shot, and the elimination of the shots' own numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.model.loops import plain
from analysis.model.loops.blocks import RIDGE, solved
from analysis.model.predict.columns import Columns
from analysis.model.predict.comparison import Comparison
from analysis.model.predict.theory import Theory

LEAST_INFORMATION = 1e-18
"""Of a parameter that no residual depends on: its variance is then 1e18."""


@dataclass(frozen=True, slots=True, eq=False)
class NormalEquations:
    """Sums of one linearisation by shot: S shots, P shared parameters.

    Attributes
    ----------
    chi2
        Shape (S,).
    states, coupling, shared
        Shapes (S, 24, 24), (S, 24, P), (S, P, P).
    state_gradient, shared_gradient
        Shapes (S, 24), (S, P): downhill.
    """

    chi2: Floats
    states: Floats
    coupling: Floats
    shared: Floats
    state_gradient: Floats
    shared_gradient: Floats

    def reduced_by_shot(self) -> tuple[Floats, Floats]:
        """Return what each shot adds to M and g, shapes (S, P, P) and (S, P)."""
        eliminated = solve_blocks(self.states, self.coupling)
        matrix = self.shared - np.swapaxes(self.coupling, 1, 2) @ eliminated
        own = (np.swapaxes(eliminated, 1, 2) @ self.state_gradient[..., None])[..., 0]
        return matrix, self.shared_gradient - own

    def chosen(self, new: NormalEquations, take: NDArray[np.bool_]) -> NormalEquations:
        """Return the new sums where `take` (S,) is true and the present ones elsewhere."""

        def pick(old: Floats, other: Floats) -> Floats:
            return np.where(take.reshape(-1, *([1] * (old.ndim - 1))), other, old)

        return NormalEquations(
            *(pick(getattr(self, name), getattr(new, name)) for name in self.__slots__)
        )

    @classmethod
    def joined(cls, parts: Sequence[NormalEquations]) -> NormalEquations:
        """Return the sums of shots that follow each other in parts."""
        return cls(*(np.concatenate([getattr(p, n) for p in parts]) for n in cls.__slots__))


def sums_of(line: Comparison, shared: Columns) -> NormalEquations:
    """Sum up a linearisation and the columns of what the shots share."""
    by_state = np.swapaxes(line.by_state, 1, 2)
    return NormalEquations(
        chi2=line.chi2,
        states=line.information,
        coupling=by_state @ shared.against_flights(line),
        shared=shared.gram(line),
        state_gradient=line.downhill,
        shared_gradient=shared.with_residual(line),
    )


def prior_cost(theory: Theory) -> float:
    """Return what the prior adds to chi-squared."""
    centre, information = theory.prior
    return float(((theory.vector - centre) ** 2 * information).sum())


def with_prior(matrix: Floats, information: Floats) -> Floats:
    """Return an information matrix with what is known beforehand of its first parameters, (P,)."""
    matrix = matrix.copy()
    index = np.arange(len(information))
    matrix[index, index] += information
    return matrix


def solve_blocks(matrices: Floats, right: Floats) -> Floats:
    """Solve each shot's block, scaled to a unit diagonal; numbers without information stay put."""
    return solved(plain(matrices), plain(right), np.zeros(len(matrices)))


def inverse(matrix: Floats) -> Floats:
    """Invert an information matrix (P, P), scaled to a unit diagonal.

    A parameter without information gets a huge variance instead of an error.
    """
    information = np.diag(matrix)
    scale = np.sqrt(np.where(information > LEAST_INFORMATION, information, LEAST_INFORMATION))
    scaled = matrix / scale[:, None] / scale[None, :]
    index = np.arange(len(matrix))
    scaled[index, index] = 1.0 + RIDGE
    return np.asarray(np.linalg.inv(scaled) / scale[:, None] / scale[None, :])


def shot_steps(sums: NormalEquations, damping: Floats) -> Floats:
    """Return each shot's own damped step, shape (S, 24); damping of shape (S,)."""
    return solved(plain(sums.states), plain(sums.state_gradient[..., None]), plain(damping))[..., 0]
