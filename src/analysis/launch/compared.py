"""Launches held against what was measured of them, traced back to the mouths of the tubes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.launch.measurement import Touches
from analysis.launch.scatter import scatter_variance
from analysis.launch.settings import LaunchSettings
from analysis.launch.theory import LaunchTheory
from analysis.launch.touch import traced_back
from analysis.model.loops.blocks import whitened

_TOUCH_STEP = np.array([1e-6] * 6 + [1e-3] * 6 + [1e-7] * 5)


@dataclass(frozen=True, slots=True, eq=False)
class Compared:
    """S launches and their touches, in the units of a muzzle.

    Attributes
    ----------
    residual
        Traced back less predicted, shape (S, 17).
    covariance
        Of the measurement, traced back, shape (S, 17, 17).
    derivative
        Of predicted less traced back by the parameters, shape (S, 17, P).
    speed
        Predicted speeds, m/s, shape (S, 2).
    """

    residual: Floats
    covariance: Floats
    derivative: Floats
    speed: Floats

    def variance(self, scatter: Floats) -> Floats:
        """Return the covariance with the scatter of each kind (K,) in, shape (S, 17, 17)."""
        total = self.covariance.copy()
        index = np.arange(total.shape[-1])
        total[:, index, index] += scatter_variance(scatter, self.speed)
        return total

    def whitened(self, scatter: Floats) -> tuple[Floats, Floats]:
        """Return residuals (S, 17) and derivatives (S, 17, P) in units of their standard errors."""
        stacked = np.concatenate([self.residual[..., None], self.derivative], axis=-1)
        both = whitened(self.variance(scatter), stacked)
        return both[..., 0], both[..., 1:]


def compare(
    theory: LaunchTheory,
    settings: LaunchSettings,
    touches: Touches,
    covariance: Floats | None = None,
) -> Compared:
    """Trace touches back to the mouths and hold the launches against them.

    Parameters
    ----------
    covariance
        Of the measurement, traced back by a theory near this one; None: by this one.
    """
    ground, vector, columns = touches.ground, theory.vector, []
    launched = theory.launch(settings, ground)
    traced = traced_back(touches.rows, theory.law, ground).row
    residual = np.asarray(traced - launched.row)
    for k, step in enumerate(theory.steps):
        shifted = vector.copy()
        shifted[k] += step
        moved = theory.at(shifted)
        if moved.law.tubes == theory.law.tubes:
            changed = traced - moved.launch(settings, ground).row
        else:
            changed = residual_at_mouths(moved, settings, touches)
        columns.append((residual - changed) / step)
    if covariance is None:
        back = _back(theory, touches)
        covariance = back @ touches.covariance @ np.swapaxes(back, 1, 2)
    return Compared(
        residual=residual,
        covariance=covariance,
        derivative=np.stack(columns, axis=-1),
        speed=launched.speed,
    )


def residual_at_mouths(theory: LaunchTheory, settings: LaunchSettings, touches: Touches) -> Floats:
    """Return the muzzles that the touches come from less those predicted, shape (S, 17)."""
    ground = touches.ground
    traced = traced_back(touches.rows, theory.law, ground)
    return np.asarray(traced.row - theory.launch(settings, ground).row)


def _back(theory: LaunchTheory, touches: Touches) -> Floats:
    """Return the derivative of the muzzle by the touch that it is traced from, (S, 17, 17)."""
    rows, steps = touches.rows, np.append(0.0, _TOUCH_STEP)
    moved = rows + np.diag(steps)[:, None, 1:]
    traced = traced_back(moved.reshape(-1, rows.shape[1]), theory.law, touches.ground).row
    here, *others = traced.reshape(moved.shape)
    return np.moveaxis((np.array(others) - here) / _TOUCH_STEP[:, None, None], 0, -1)
