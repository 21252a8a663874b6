"""Least squares of the numbers of a fit of flights, with what is known of them beforehand."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from analysis.arrays import Floats
from analysis.balls.flight import path
from analysis.balls.flight.flights import Ints
from analysis.balls.flight.problem import Problem

Chosen = tuple[Ints, NDArray[np.bool_], Floats]
"""Which flight each place belongs to, whether it counts, and by how much its errors are larger."""

LOOSE, CLOSE = 1e-4, 1e-8
"""Share of the sum of squares by which a step is the last: while the fit settles, and then."""
STEP = 1e-5
"""Of numbers in their units, by which derivatives are taken."""
SOFT = 2.0
"""Residuals beyond so many standard errors count less while the fit settles."""


def solve(
    problem: Problem, values: Floats, chosen: Chosen, loose: NDArray[np.bool_], *, soft: bool
) -> Floats:
    """Return the numbers that fit the places that count best, of those that are loose.

    Parameters
    ----------
    values
        Where the search begins, shape (P,).
    soft
        Whether places far off count less.
    """
    arcs, used, enlarge = chosen
    units = problem.units[loose]
    known = np.isfinite(problem.prior_sigma) & loose
    errors = (problem.observed.sigmas * enlarge)[used]
    drifts = problem.drifts if loose[path.DEPTH] else problem.drifts[:0]
    straight = np.vstack(
        [_straight_slopes(problem, known, loose), (drifts * problem.units)[:, loose]]
    )

    def at(step: Floats) -> Floats:
        moved = values.copy()
        moved[loose] += step * units
        return moved

    counted = np.flatnonzero(used)
    own = (problem.observed.places[used] / errors).ravel()
    # The search's place, and one a step aside in each of its numbers.
    aside = np.vstack([np.zeros(len(units)), STEP * np.eye(len(units))])

    def seen(moved: Floats) -> Floats:
        each = problem.predict_each(moved, arcs)[0][:, counted, :2] / errors
        return np.asarray(each.reshape(len(moved), -1))

    def residuals(step: Floats) -> Floats:
        moved = at(step)
        every = np.concatenate([own - seen(moved[None])[0], off_beliefs(problem, moved, loose)])
        return _finite(every, 1e6, 1e6)

    def slopes(step: Floats) -> Floats:
        moved = np.tile(values, (len(units) + 1, 1))
        moved[:, loose] += (step + aside) * units
        each = seen(moved)
        own = _finite((each[0] - each[1:]) / STEP).T
        beyond = (problem.beyond(moved[0])[1] * problem.units)[:, loose]
        return np.vstack([own, straight, beyond])

    loss: Literal["soft_l1", "linear"] = "soft_l1" if soft else "linear"
    solved = least_squares(
        residuals,
        np.zeros(len(units)),
        jac=slopes,
        loss=loss,
        f_scale=SOFT,
        max_nfev=60,
        ftol=LOOSE if soft else CLOSE,
    )
    return at(solved.x)


def off_beliefs(problem: Problem, values: Floats, loose: NDArray[np.bool_]) -> Floats:
    """Return by how much the loose numbers are off what is known of them beforehand, in errors."""
    known = np.isfinite(problem.prior_sigma) & loose
    prior = (values[known] - problem.prior[known]) / problem.prior_sigma[known]
    start = problem.start
    lean = (values[path.LEVEL].sum(keepdims=True) - start.lean) / start.lean_sigma
    drifts = problem.drifts @ values - problem.drifts_target
    return np.concatenate(
        [
            prior,
            lean if loose[path.LEVEL].all() else lean[:0],
            drifts if loose[path.DEPTH] else drifts[:0],
            problem.beyond(values)[0],
        ]
    )


def _finite(numbers: Floats, nan: float = 0.0, most: float = np.finfo(float).max) -> Floats:
    """Return numbers that a sum of squares can hold. Nearly always all are, and that is faster."""
    if np.isfinite(numbers).all():
        return numbers
    return np.asarray(np.nan_to_num(numbers, nan=nan, posinf=most, neginf=-most))


def _straight_slopes(
    problem: Problem, known: NDArray[np.bool_], loose: NDArray[np.bool_]
) -> Floats:
    """Return derivatives of what is known beforehand to the numbers that are fitted, in units."""
    each = np.zeros((int(known.sum()), len(loose)))
    each[:, known] = np.diag(problem.units[known] / problem.prior_sigma[known])
    level = np.zeros((1, len(loose)))
    level[0, path.LEVEL] = problem.units[path.LEVEL] / problem.start.lean_sigma
    return np.vstack([each, level] if loose[path.LEVEL].all() else [each])[:, loose]
