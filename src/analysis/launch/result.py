"""What a fit of the launches found, and what it foretells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.launch.compared import Compared
from analysis.launch.measurement import Touches
from analysis.launch.predicted_touch import predict_touch
from analysis.launch.prediction import Limits, Prediction, check_meeting
from analysis.launch.scatter import KINDS
from analysis.launch.settings import LaunchSettings
from analysis.launch.theory import LaunchTheory
from analysis.quantity import Quantity


@dataclass(frozen=True, slots=True, eq=False)
class LaunchFit:
    """Fitted launches.

    Attributes
    ----------
    theory
        Pushers, tubes and effects.
    covariance
        Of the theory's parameters, shape (P, P).
    scatter
        Of each of `scatter.KINDS` from shot to shot, in SI units, of speeds relative, shape (K,).
    freedom
        Degrees of freedom of each kind, shape (K,).
    compared
        Residuals and derivatives at the minimum.
    settings, touches
        What was fitted.
    rejected
        Numbers of the shots that were left out as misfires.
    converged
        Whether parameters and scatter had settled.
    """

    theory: LaunchTheory
    covariance: Floats
    scatter: Floats
    freedom: Floats
    compared: Compared
    settings: LaunchSettings
    touches: Touches
    rejected: NDArray[np.intp]
    converged: bool

    @property
    def shots(self) -> NDArray[np.intp]:
        """Numbers of the shots that were fitted, shape (S,)."""
        return self.touches.shots

    def parameters(self) -> dict[str, Quantity]:
        """Return every parameter with its standard error."""
        sigma = np.sqrt(np.diag(self.covariance))
        rows = zip(self.theory.names, self.theory.vector, sigma, self.theory.units, strict=True)
        return {name: Quantity(float(v), float(s), unit) for name, v, s, unit in rows}

    def spread(self) -> dict[str, Quantity]:
        """Return the scatter of each kind, relative to the speed where it is in proportion to it.

        Its error is that of a standard deviation, s / sqrt(2 x degrees of freedom).
        """
        return {
            kind.name: Quantity(
                float(s) * kind.factor,
                float(s) * kind.factor / np.sqrt(2 * nu),
                "1" if kind.relative else kind.unit,
            )
            for kind, s, nu in zip(KINDS, self.scatter, self.freedom, strict=True)
        }

    def predict(self, settings: LaunchSettings, limits: Limits | None = None) -> Prediction:
        """Foretell shots from their settings, with the errors of parameters and scatter.

        Parameters
        ----------
        limits
            What the rig allows; None: nothing is checked but that the spheres meet.

        Raises
        ------
        LaunchRefusedError
            A setting lies outside the limits, a pressure leaves a sphere in its tube, or the
            spheres miss each other.
        """
        if limits is not None:
            limits.check(settings)
        predicted = predict_touch(self.theory, settings, self.touches.ground)
        check_meeting(predicted, settings)
        return Prediction(predicted, self.covariance, self.scatter, self.touches.time_s)
