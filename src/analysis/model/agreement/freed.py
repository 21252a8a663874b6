"""Every contact's outcome set free: after it, velocities and spins are what the poses want.

Under a law that is far off, a shot's fit lies between what it was before contact and what it was
after, as much as ten standard errors from either. What is left there is not linear in what is
wrong, and would pass for forces and for a bent image.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from analysis.arrays import Floats
from analysis.model.agreement.outcome import jump_covariance
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import Fit
from analysis.model.fitting.normal import solve_blocks
from analysis.model.predict.comparison import compare
from analysis.model.predict.contact import AFTER, contact_outcome
from analysis.model.rank.projector import eliminated
from analysis.model.structure.channels import contact_columns, contact_frame, pairs_of
from analysis.motion.exponential import exponential

ROUNDS = 6
LITTLE_FALL = 0.1


@dataclass(frozen=True, slots=True, eq=False)
class Freed:
    """A fit whose contacts leave behind what the poses want.

    Attributes
    ----------
    data
        Poses less what the outcomes differ from the law's.
    fit
        With the shots' own numbers that go with them.
    """

    data: PoseData
    fit: Fit


def with_free_outcomes(data: PoseData, fit: Fit) -> Freed:
    """Fit each shot's own numbers and outcome at fixed shared parameters, from where it stands.

    A shot that gains nothing by a step stays.
    """
    jumps = np.zeros((len(data.shots), 2, len(pairs_of(data)), 3))
    here = Freed(data, fit)
    chi2 = compare(data, fit.states, fit.theory)[0].chi2
    for _ in range(ROUNDS):
        change, step = _steps(here)
        moved = fit.with_states(here.fit.states.moved(step))
        tried = Freed(_less(data, moved, jumps + change), moved)
        new = compare(tried.data, moved.states, moved.theory)[0].chi2
        better = new < chi2
        fall = float((chi2 - new)[better].sum())
        jumps = np.where(better[:, None, None, None], jumps + change, jumps)
        chosen = fit.with_states(here.fit.states.chosen(moved.states, better))
        here = Freed(_less(data, chosen, jumps), chosen)
        chi2 = np.where(better, new, chi2)
        if fall < LITTLE_FALL:
            break
    return here


def _steps(here: Freed) -> tuple[Floats, Floats]:
    """Return by how much outcomes and own numbers are to move.

    Velocities and spins, of each of the W motions of both bodies, in rig axes, shape (S, 2, W, 3),
    and (S, 24).
    """
    states, theory = here.fit.states, here.fit.theory
    sums, _, _ = eliminated(here.data, states, theory)
    jumps = contact_columns(here.data, states, theory)
    columns = np.concatenate(list(jumps.values()), axis=2)
    by_shot = sums.project(columns)
    covariance, _ = jump_covariance(by_shot)
    change = covariance @ by_shot.gradient[..., None]
    if sums.noise is not None:
        columns = sums.noise.whiten_frames(columns)
    taken = np.swapaxes(sums.by_state, 1, 2) @ (columns @ change)
    step = solve_blocks(sums.states, sums.own_gradient[..., None] - taken)[..., 0]
    axes = np.stack(contact_frame(here.data, states), axis=1)
    return np.einsum("skwa,sax->skwx", change.reshape(*here.data.shots.shape, 2, -1, 3), axes), step


def _less(data: PoseData, fit: Fit, jumps: Floats) -> PoseData:
    """Take out of the poses what jumps of the outcome (S, 2, W, 3) do to them."""
    tau = np.maximum(data.times_s - fit.states.time_s[:, None], 0.0)[:, :, None, None]
    shares = np.array([share for _, share in pairs_of(data)])
    velocity, spin = np.moveaxis(np.einsum("wi,skwx->skix", shares, jumps), 1, 0)
    after = contact_outcome(data, fit.states, fit.theory)[:, AFTER].reshape(-1, 4, 3)[:, 2:]
    turned, back = (exponential(w[:, None] * tau)[0] for w in (after, -(after + spin)))
    return replace(
        data,
        position=data.position - velocity[:, None] * tau,
        rotation=turned @ back @ data.rotation,
    )
