"""Launches held against what was measured of them, carried back to the mouths of the tubes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.launch.foretold import foretell
from analysis.launch.measurement import Touches
from analysis.launch.scatter import scatter_variance
from analysis.launch.settings import LaunchSettings
from analysis.launch.theory import LaunchTheory

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Compared:
    """S launches and their touches, in the units of a muzzle.

    Attributes
    ----------
    residual
        u = H^-1 (measured - foretold), shape (S, 17).
    covariance
        Of the measurement, carried back likewise, shape (S, 17, 17).
    derivative
        Of what is foretold by the parameters, likewise, shape (S, 17, P).
    speed
        Foretold speeds, m/s, shape (S, 2).
    back
        H^-1, shape (S, 17, 17).
    """

    residual: Floats
    covariance: Floats
    derivative: Floats
    speed: Floats
    back: Floats

    def variance(self, scatter: Floats) -> Floats:
        """Return the covariance with the scatter of each kind (K,) in, shape (S, 17, 17)."""
        total = self.covariance.copy()
        index = np.arange(total.shape[-1])
        total[:, index, index] += scatter_variance(scatter, self.speed)
        return total

    def whitened(self, scatter: Floats) -> tuple[Floats, Floats]:
        """Return residuals (S, 17) and derivatives (S, 17, P) in units of their standard errors."""
        root = np.linalg.cholesky(self.variance(scatter))
        stacked = np.concatenate([self.residual[..., None], self.derivative], axis=-1)
        both = np.linalg.solve(root, stacked)
        return both[..., 0], both[..., 1:]


def compare(theory: LaunchTheory, settings: LaunchSettings, touches: Touches) -> Compared:
    """Hold launches against their touches and carry everything back to the mouths."""
    foretold = foretell(theory, settings, touches.ground)
    back = np.asarray(np.linalg.inv(foretold.by_muzzle))
    return Compared(
        residual=(back @ (touches.rows - foretold.touch)[..., None])[..., 0],
        covariance=back @ touches.covariance @ np.swapaxes(back, 1, 2),
        derivative=back @ foretold.by_theory,
        speed=foretold.muzzle.speed,
        back=back,
    )
