"""Agreement of poses: of those before contact with each other, of those after with the prediction.

Before contact each shot's own numbers follow the poses, and a plain count of degrees of freedom
misleads. With H the hat matrix of everything fitted, residuals of a group have the covariance
Q = 1 - H on that group: chi-squared has the mean tr Q and the variance 2 tr Q^2.

After contact each shot is predicted from its poses before alone: what is missed there has the
covariance S = 1 + J_after (J_before' J_before)^-1 J_after', less what the shared parameters took.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.model.agreement.heldout import left_out_steps
from analysis.model.agreement.table import Row, Spread, root_mean
from analysis.model.fitting.normal import solve_blocks
from analysis.model.rank.projector import Projector

Mask = NDArray[np.bool_]

UNITS = {"position": ("mm", 1e3), "orientation": ("mrad", 1e3)}


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """Some of the N numbers of each shot, all measured: mask of shape (S, N)."""

    quantity: str
    kind: str
    mask: Mask

    @property
    def numbers(self) -> NDArray[np.intp]:
        """Those that are in the group in any shot: nothing else is to be gone over."""
        return np.flatnonzero(self.mask.any(axis=0))


def pose_groups(measured: Mask, side: Mask) -> tuple[Group, ...]:
    """Return positions and orientations of a and b in the frames of one side.

    Parameters
    ----------
    measured
        Shape (S, F, 2, 6).
    side
        Frames, shape (S, F).
    """
    groups = []
    for kind, part in (("position", slice(0, 3)), ("orientation", slice(3, 6))):
        for i, name in enumerate("ab"):
            mask = np.zeros_like(measured)
            mask[:, :, i, part] = measured[:, :, i, part] & side[..., None]
            groups.append(Group(f"{kind} {name}", kind, mask.reshape(len(mask), -1)))
    return tuple(group for group in groups if group.mask.any())


@dataclass(frozen=True, slots=True, eq=False)
class Side:
    """A fit seen from some frames alone; attributes as in `Projector`, zero in all other frames."""

    residual: Floats
    by_state: Floats
    states: Floats
    shared: Floats
    covariance: Floats

    def at(self, numbers: NDArray[np.intp]) -> Side:
        """Return some of the N numbers of each shot alone."""
        residual, by_state, shared = (
            part[:, numbers] for part in (self.residual, self.by_state, self.shared)
        )
        return replace(self, residual=residual, by_state=by_state, shared=shared)


def hat_spread(sums: Side, mask: Mask) -> Spread:
    """Return mean and variance of chi-squared of the residuals in a group."""
    own = sums.by_state * mask[..., None]
    shared = sums.shared * mask[..., None]
    taken = solve_blocks(sums.states, np.swapaxes(own, 1, 2) @ own)
    between = np.swapaxes(own, 1, 2) @ shared
    solved = solve_blocks(sums.states, between)
    law = sums.covariance @ np.einsum("snp,snq->pq", shared, shared, optimize=True)
    cross = sums.covariance @ np.einsum("skp,skq->pq", between, solved, optimize=True)
    trace = float(np.trace(taken, axis1=1, axis2=2).sum() + np.trace(law))
    square = float(np.einsum("sij,sji->", taken, taken))
    square += float(np.trace(law @ law) + 2 * np.trace(cross))
    count = float(mask.sum())
    return Spread(count - trace, 2 * (count - 2 * trace + square))


@dataclass(frozen=True, slots=True, eq=False)
class Sides:
    """What the poses before contact say of each shot, and what they leave to be said.

    Attributes
    ----------
    before
        The fit seen from the frames before contact.
    missed, by_theory
        What a prediction from there misses after contact, and its derivative by the shared
        parameters, shapes (S, N) and (S, N, P).
    left_out
        The same with parameters from the other folds, shape (S, N).
    by_state
        Derivative of the poses after contact by the shot's own numbers, shape (S, N, 24).
    """

    before: Side
    missed: Floats
    by_theory: Floats
    left_out: Floats
    by_state: Floats


def sides(sums: Projector, before: Mask) -> Sides:
    """Split a fit at the contact; `before` (S, N) marks what was measured before it."""
    known = sums.by_state * before[..., None]
    information = np.swapaxes(known, 1, 2) @ known

    def less_state(columns: Floats) -> Floats:
        state = solve_blocks(information, np.swapaxes(known, 1, 2) @ columns)
        return np.asarray(columns - sums.by_state @ state)

    missed = less_state(sums.residual[..., None])[..., 0]
    by_theory = less_state(sums.shared)
    moved = (by_theory @ left_out_steps(sums)[..., None])[..., 0]
    return Sides(
        before=Side(
            residual=missed * before,
            by_state=known,
            states=information,
            shared=by_theory * before[..., None],
            covariance=sums.covariance,
        ),
        missed=missed,
        by_theory=by_theory,
        left_out=missed - moved,
        by_state=sums.by_state,
    )


def fitted_row(before: Side, group: Group, sigma: Floats) -> Row:
    """Return how the frames before contact fit each other, sigma of shape (S, N)."""
    own, mask = before.at(group.numbers), group.mask[:, group.numbers]
    residual, by_shot = own.residual[mask], (own.residual**2 * mask).sum(axis=1)
    chi2, spread = float(residual @ residual), hat_spread(own, mask)
    unit, scale = UNITS[group.kind]
    sigma = scale * sigma[group.mask]
    kept = (1.0 - _leverage(own))[mask]
    return Row(
        quantity=group.quantity,
        unit=unit,
        count=residual.size,
        chi2=chi2,
        freedom=spread.mean,
        p_value=spread.p_value(chi2),
        error=root_mean(chi2, spread.mean),
        sampling=spread.sampling,
        size=root_mean(float(((residual * sigma) ** 2).sum()), residual.size),
        floor=root_mean(float((kept * sigma**2).sum()), residual.size),
        p_rest=spread.p_rest(by_shot),
    )


def predicted_row(split: Sides, group: Group, sigma: Floats) -> Row:
    """Return how well a group after contact is predicted from before it, sigma (S, N)."""
    information, numbers = split.before.states, group.numbers
    mask = group.mask[:, numbers]
    own = split.by_state[:, numbers] * mask[..., None]
    whole = information + np.swapaxes(own, 1, 2) @ own

    def product(columns: Floats) -> Floats:
        """Return C' S^-1 C of each shot, by Woodbury, for columns (S, N, C)."""
        columns = columns[:, numbers] * mask[..., None]
        pull = np.swapaxes(own, 1, 2) @ columns
        inner = np.swapaxes(pull, 1, 2) @ solve_blocks(whole, pull)
        return np.asarray(np.swapaxes(columns, 1, 2) @ columns - inner)

    by_shot = product(split.missed[..., None]).sum(axis=(1, 2))
    chi2, left_out = float(by_shot.sum()), float(product(split.left_out[..., None]).sum())
    taken = split.before.covariance @ product(split.by_theory).sum(axis=0)
    spread = Spread.less(float(group.mask.sum()), taken)
    reached = solve_blocks(information, np.swapaxes(own, 1, 2))
    variance = 1.0 + (own * np.swapaxes(reached, 1, 2)).sum(axis=2)
    missed, count = split.left_out[group.mask], int(group.mask.sum())
    unit, scale = UNITS[group.kind]
    sigma = scale * sigma[group.mask]
    return Row(
        quantity=group.quantity,
        unit=unit,
        count=count,
        chi2=chi2,
        freedom=spread.mean,
        p_value=spread.p_value(chi2),
        error=root_mean(left_out, count),
        sampling=float(np.sqrt(0.5 / count)),
        size=root_mean(float(((missed * sigma) ** 2).sum()), count),
        floor=root_mean(float((variance[mask] * sigma**2).sum()), count),
        p_rest=spread.p_rest(by_shot),
    )


def _leverage(sums: Side) -> Floats:
    """Return the diagonal of the hat matrix, shape (S, N)."""
    solved = solve_blocks(sums.states, np.swapaxes(sums.by_state, 1, 2))
    own = (sums.by_state * np.swapaxes(solved, 1, 2)).sum(axis=2)
    return np.asarray(own + ((sums.shared @ sums.covariance) * sums.shared).sum(axis=2))
