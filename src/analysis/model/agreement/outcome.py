"""Agreement of what the contact leaves behind: velocities and spins after it, shot by shot.

For each shot the velocities and spins after contact are set free: d = M^-1 C' (1 - P) r is by how
much the poses want them changed, M^-1 their covariance, with C the twelve jumps of `channels` and P
what the shot's own numbers can imitate. With parameters fitted to the same shots, d whitened has
the covariance 1 - D V D', D its derivative by them and V their covariance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.model.agreement.heldout import left_out_steps
from analysis.model.agreement.table import Row, Spread, root_mean
from analysis.model.rank.projector import ByShot, Projector

GROUPS: tuple[tuple[str, str, tuple[str, ...]], ...] = (
    ("normal velocity", "mm/s", ("relative velocity n",)),
    ("tangential velocity", "mm/s", ("relative velocity t",)),
    ("velocity out of plane", "mm/s", ("relative velocity b",)),
    ("common velocity", "mm/s", ("common velocity n", "common velocity t", "common velocity b")),
    ("relative spin", "rad/s", ("relative spin n", "relative spin t", "relative spin b")),
    ("common spin", "rad/s", ("common spin n", "common spin t", "common spin b")),
)
"""Rows, their unit, and the channels in them."""
LEAST_INFORMATION, LARGEST_INFLATION = 1e-6, 1e6
"""A jump of which less is left, or whose variance the others raise by more, is not measured."""
RIDGE = 1e-10


@dataclass(frozen=True, slots=True, eq=False)
class Outcomes:
    """Changes that the poses want of what the model predicts after contact, C jumps in S shots.

    Attributes
    ----------
    names
        Of the jumps.
    change, left_out
        In m/s and rad/s, by the fit and with parameters from the other folds, shape (S, C).
    covariance
        Of each shot's jumps with the parameters given, shape (S, C, C).
    by_theory
        What one unit of each parameter takes off the change, shape (S, C, P).
    seen
        Whether a jump is measured in a shot, shape (S, C).
    """

    names: tuple[str, ...]
    change: Floats
    left_out: Floats
    covariance: Floats
    by_theory: Floats
    seen: NDArray[np.bool_]


def outcomes(sums: Projector, jumps: dict[str, Floats]) -> Outcomes:
    """Set the outcome of every contact free; jumps as `contact_columns` gives them."""
    by_shot = sums.project(np.concatenate(list(jumps.values()), axis=2))
    covariance, seen = jump_covariance(by_shot)
    change = (covariance @ by_shot.gradient[..., None])[..., 0]
    by_theory = covariance @ by_shot.against
    moved = (by_theory @ left_out_steps(sums)[..., None])[..., 0]
    return Outcomes(tuple(jumps), change, change - moved, covariance, by_theory, seen)


def jump_covariance(by_shot: ByShot) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the covariance of each shot's jumps (S, C, C), zero for those without information.

    And whether a jump is measured, shape (S, C).
    """
    diagonal = np.diagonal(by_shot.own, axis1=1, axis2=2)
    informed = diagonal > LEAST_INFORMATION * by_shot.raw
    scale = np.where(informed, np.sqrt(np.maximum(diagonal, 1e-300)), 1.0)
    both = informed[:, :, None] & informed[:, None, :]
    scaled = np.where(both, by_shot.own / scale[:, :, None] / scale[:, None, :], 0.0)
    index = np.arange(scaled.shape[1])
    scaled[:, index, index] = 1.0 + RIDGE
    inverted = np.linalg.inv(scaled)
    inflation = np.diagonal(inverted, axis1=1, axis2=2)
    covariance = np.where(both, inverted / scale[:, :, None] / scale[:, None, :], 0.0)
    return covariance, informed & (inflation < LARGEST_INFLATION)


def outcome_rows(found: Outcomes, theory_covariance: Floats) -> list[Row]:
    """Return a row for each group of jumps that some shot measures."""
    rows = []
    for quantity, unit, names in GROUPS:
        own = [found.names.index(name) for name in names if name in found.names]
        used = np.asarray(found.seen[:, own].all(axis=1))
        if own and used.any():
            rows.append(_row(found, theory_covariance, (quantity, unit), own, used=used))
    return rows


def _row(
    found: Outcomes,
    theory_covariance: Floats,
    title: tuple[str, str],
    own: list[int],
    *,
    used: NDArray[np.bool_],
) -> Row:
    covariance = found.covariance[used][:, own][:, :, own]
    root = np.linalg.cholesky(covariance)
    change, left_out = (part[used][:, own] for part in (found.change, found.left_out))
    white = np.linalg.solve(root, change[..., None])
    missed = np.linalg.solve(root, left_out[..., None])
    response = np.linalg.solve(root, found.by_theory[used][:, own])
    taken = theory_covariance @ np.einsum("sgp,sgq->pq", response, response)
    count = change.size
    spread = Spread.less(count, taken)
    by_shot, (quantity, unit) = (white**2).sum(axis=(1, 2)), title
    chi2 = float(by_shot.sum())
    scale = 1e3 if unit == "mm/s" else 1.0
    return Row(
        quantity=quantity,
        unit=unit,
        count=count,
        chi2=chi2,
        freedom=spread.mean,
        p_value=spread.p_value(chi2),
        error=root_mean(float((missed**2).sum()), count),
        sampling=float(np.sqrt(0.5 / count)),
        size=scale * root_mean(float((left_out**2).sum()), count),
        floor=scale * root_mean(float(np.trace(covariance, axis1=1, axis2=2).sum()), count),
        p_rest=spread.p_rest(by_shot),
    )
