"""Every contact's outcome set free: after it, velocities and spins are what the poses want.

Under a law that is far off, a shot's fit lies between what it was before contact and what it was
after, as much as ten standard errors from either. What is left there is not linear in what is
wrong, and would pass for forces and for a bent image. About such a fit measured paths are held
against those that the model predicts from before the contact (`predicted_paths`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.model.agreement.outcome import jump_covariance
from analysis.model.data.poses import PoseData
from analysis.model.data.tables import Data
from analysis.model.fitting.fit import Fit
from analysis.model.fitting.normal import solve_blocks
from analysis.model.predict.comparison import compare
from analysis.model.predict.contact import AFTER, contact_outcome
from analysis.model.predict.prediction import predict
from analysis.model.rank.projector import eliminated
from analysis.model.structure.channels import contact_columns, contact_frame, pairs_of
from analysis.motion.exponential import exponential
from analysis.schema.codec import Json

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


LOOKED_AT = 40
"""So many shots, spread over the campaign, are compared: one is shown."""
SHARES = (0.5, 1.0, 0.0)
"""Of the shots in the order of their gaps: a typical one first, then the largest and the least."""
MM = 1e3
DIGITS = 4


@dataclass(frozen=True, slots=True, eq=False)
class PredictedPaths:
    """One shot, F frames, spheres in the order a, b; rig axes.

    Attributes
    ----------
    shot
        Its number.
    time_s
        Of each frame from the shot's first, shape (F,); `contact_s` is that of first touch.
    measured, predicted
        Centres, m, shape (F, 2, 3); measured is not finite where nothing was.
    """

    shot: int
    time_s: Floats
    contact_s: float
    measured: Floats
    predicted: Floats

    @property
    def gap(self) -> float:
        """Largest distance between a predicted and a measured centre after contact, m."""
        after = self.time_s > self.contact_s
        apart = np.linalg.norm((self.predicted - self.measured)[after], axis=-1)
        return float(np.nanmax(apart, initial=0.0)) if np.isfinite(apart).any() else 0.0


def predicted_paths(data: Data, fit: Fit) -> tuple[PredictedPaths, ...]:
    """Return a typical shot, and those with the largest and the least gap; none of a table."""
    if not isinstance(data, PoseData) or not len(data.shots):
        return ()
    chosen = np.zeros(len(data.shots), dtype=np.bool_)
    chosen[np.linspace(0, len(data.shots) - 1, LOOKED_AT).round().astype(np.intp)] = True
    ordered = sorted(_of_shots(data, fit, chosen), key=lambda path: path.gap)
    places = dict.fromkeys(round(share * (len(ordered) - 1)) for share in SHARES)
    return tuple(ordered[place] for place in places)


def _of_shots(data: PoseData, fit: Fit, chosen: NDArray[np.bool_]) -> list[PredictedPaths]:
    """Return the paths of the chosen shots, a mask (S,).

    The state before contact is what the poses say with the outcome set free (`with_free_outcomes`),
    so that a wrong law cannot pull it toward what came after.
    """
    some, own = data.of_shots(chosen), fit.with_states(fit.states.of_shots(chosen))
    states = with_free_outcomes(some, own).fit.states
    predicted = predict(some, states, fit.theory).position
    # Along a direction that no view shows the spheres are where the model has them.
    seen = np.isfinite(some.position_sigma)
    placed = np.where(seen, some.position, predicted)
    measured = np.where(seen.any(axis=-1, keepdims=True), placed, np.nan)
    return [
        PredictedPaths(
            shot=int(number),
            time_s=some.times_s[s],
            contact_s=float(states.time_s[s]),
            measured=measured[s],
            predicted=predicted[s],
        )
        for s, number in enumerate(some.shots)
    ]


def paths_document(data: Data, fit: Fit, shot: int | None = None) -> list[Json]:
    """Return these shots in mm and ms, times from first touch; null where nothing was measured.

    Parameters
    ----------
    shot
        Number of the one shot that is wanted; None: a typical one and those with the largest and
        the least gap. Nothing is returned of a shot that the fit left out, or of a table.
    """
    radii = [_rounded(MM * body.radius) for body in data.bodies]
    paths: Sequence[PredictedPaths] = ()
    if shot is None:
        paths = predicted_paths(data, fit)
    elif isinstance(data, PoseData) and (chosen := data.shots == shot).any():
        paths = _of_shots(data, fit, chosen)
    return [_document(one) | {"radii_mm": radii} for one in paths]


def _document(paths: PredictedPaths) -> Json:
    used = np.isfinite(paths.measured).any(axis=(1, 2))
    gaps = paths.predicted - paths.measured
    return {
        "shot": paths.shot,
        "gap_mm": _rounded(MM * paths.gap),
        "contact_ms": _rounded(1e3 * paths.contact_s),
        "times_ms": [_rounded(1e3 * float(t - paths.contact_s)) for t in paths.time_s[used]],
        "measured": [[_point(MM * own) for own in both] for both in paths.measured[used]],
        "gaps": [[_point(MM * own) for own in both] for both in gaps[used]],
    }


def _point(values: Floats) -> list[float] | None:
    return [_rounded(float(v)) for v in values] if np.isfinite(values).all() else None


def _rounded(value: float) -> float:
    return round(value, DIGITS)
