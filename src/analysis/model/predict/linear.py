"""The comparison frame by frame: residuals and derivatives of every number that a frame gives.

The same as in comparison.py, spread out: what a test or a picture of single residuals needs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import Effect
from analysis.model.data.poses import PoseData
from analysis.model.data.tables import Data
from analysis.model.fitting.jitter import by_frame
from analysis.model.fitting.normal import solve_blocks
from analysis.model.fitting.shared_noise import SharedNoise
from analysis.model.predict.columns import all_columns
from analysis.model.predict.comparison import KINDS, compare, misfit
from analysis.model.predict.prediction import Poses
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import Theory
from analysis.motion.exponential import exponential


@dataclass(frozen=True, slots=True, eq=False)
class Linearised:
    """Whitened residuals and derivatives of the prediction, N numbers for each of S shots.

    N = 12 F for poses.

    Attributes
    ----------
    residual
        (observed - predicted) / sigma; orientations as rotation vectors of R_observed
        R_predicted'. Zero where nothing was measured. Shape (S, N).
    by_state
        Whitened derivatives of the prediction by the 24 numbers of the shot, shape (S, N, 24).
    by_theory
        The same by the parameters that all shots share, shape (S, N, P).
    states, own_gradient
        Information on the 24 numbers, (S, 24, 24), and downhill, (S, 24).
    shared
        Noise that all numbers of a frame share, where the data have such.
    """

    residual: Floats
    by_state: Floats
    by_theory: Floats
    states: Floats
    own_gradient: Floats
    shared: SharedNoise | None

    def without_states(self) -> tuple[Floats, Floats, Floats]:
        """Return what the shots' own numbers leave to those that all share.

        The derivatives by them less what the shots' own can imitate, (S, N, P); the information on
        them, (P, P); and downhill by them, (P,).
        """
        coupling = np.swapaxes(self.by_state, 1, 2) @ self.by_theory
        free = self.by_theory - self.by_state @ solve_blocks(self.states, coupling)
        flat = free.reshape(self.residual.size, -1)
        information = self.by_theory.reshape(flat.shape).T @ flat
        return free, information, self.residual.ravel() @ flat


def linearise(
    data: Data,
    states: ShotStates,
    theory: Theory,
    effects: Sequence[Effect] = (),
    given: Floats | None = None,
) -> Linearised:
    """Predict all poses and compare them with the data, to first order about states and theory.

    Parameters
    ----------
    effects
        Whose parameters, where they are off, follow those of the theory in `by_theory`.
    given
        Further columns of frames between the two, as of `all_columns`.
    """
    line, here = compare(data, states, theory)
    shared = all_columns(data, states, theory, line=line, here=here, effects=effects, given=given)
    shots, blocks, _, size = line.slopes.shape
    flown = np.setdiff1d(np.arange(shared.moved.shape[2]), shared.framed)
    by_theory = np.empty((*line.residual.shape, shared.moved.shape[2]))
    by_theory[..., flown] = line.slopes @ shared.moved[..., flown].reshape(shots, blocks, size, -1)
    by_theory[..., shared.framed] = shared.frames
    by_state = line.slopes @ line.by_state.reshape(shots, blocks, size, -1)
    spread = (line.residual[..., None], by_state, by_theory)
    framed = [by_frame(part) if blocks == KINDS else part[:, 0] for part in spread]
    return Linearised(
        residual=framed[0][..., 0],
        by_state=framed[1],
        by_theory=framed[2],
        states=line.information,
        own_gradient=line.downhill,
        shared=line.shared,
    )


def whitened_residual(data: PoseData, poses: Poses) -> Floats:
    """Return (observed - predicted) / sigma of every number, shape (S, N)."""
    return by_frame(misfit(data, poses)[..., None])[..., 0]


def left_jacobian(vector: Floats) -> Floats:
    """Return d log(exp(v + dv) exp(-v)) / dv of rotation vectors, (..., 3) to (..., 3, 3)."""
    return exponential(vector)[1]
