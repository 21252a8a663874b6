"""How well settings predict_touch launches: one row for each quantity of the muzzle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.launch.fit import fit_launch
from analysis.launch.muzzle import SIZE
from analysis.launch.result import LaunchFit
from analysis.launch.scatter import KINDS
from analysis.launch.settings import LaunchSettings
from analysis.model.data.tables import Data
from analysis.model.fitting.fit import Fit


@dataclass(frozen=True, slots=True)
class LaunchAgreement:
    """One quantity of the launch over a campaign.

    Attributes
    ----------
    quantity, unit
        Name, and unit of `scatter` and `prediction_rms`.
    count, freedom
        Numbers that enter, and their degrees of freedom.
    chi2
        With the errors of the measurement alone: far above `freedom`, as launches scatter.
    chi2_with_scatter
        With the scatter in the error: `freedom` where there is scatter, as it was so estimated.
    scatter
        Standard deviation from shot to shot beyond the measurement's errors; of speeds, at their
        root mean square.
    prediction_rms
        Root mean square of measured less predicted, each shot left out of its own fit.
    """

    quantity: str
    unit: str
    count: int
    freedom: float
    chi2: float
    chi2_with_scatter: float
    scatter: float
    prediction_rms: float


def launch_agreement(
    data: Data, fit: Fit, *, settings: LaunchSettings | None = None
) -> tuple[LaunchAgreement, ...]:
    """Fit the launches; return scatter and prediction error of each quantity.

    Raises
    ------
    LaunchRefusedError
        As of `fit.fit_launch`.
    """
    return agreement_of(fit_launch(data, fit, settings=settings))


def agreement_of(launch: LaunchFit) -> tuple[LaunchAgreement, ...]:
    """Return the rows of a fit, in the order of `scatter.KINDS`."""
    compared = launch.compared
    bare = np.diagonal(compared.covariance, axis1=1, axis2=2)
    full = np.diagonal(compared.variance(launch.scatter), axis1=1, axis2=2)
    squares, left_out = compared.residual**2, residual_left_out(launch) ** 2
    rows = []
    for kind, s, freedom in zip(KINDS, launch.scatter, launch.freedom, strict=True):
        own = list(kind.columns)
        speed = float(np.sqrt((compared.speed**2).mean())) if kind.relative else 1.0
        rows.append(
            LaunchAgreement(
                quantity=kind.name,
                unit=kind.unit,
                count=int(squares[:, own].size),
                freedom=float(freedom),
                chi2=float((squares / bare)[:, own].sum()),
                chi2_with_scatter=float((squares / full)[:, own].sum()),
                scatter=float(s) * speed * kind.factor,
                prediction_rms=float(np.sqrt(left_out[:, own].mean())) * kind.factor,
            )
        )
    return tuple(rows)


def residual_left_out(launch: LaunchFit) -> Floats:
    """Return each shot's residual from the parameters of all others, shape (S, 17).

    (I - J P J' V^-1)^-1 u, one Newton step from the parameters of all shots.
    """
    compared = launch.compared
    derivative = compared.derivative
    taken = derivative @ launch.covariance @ np.swapaxes(derivative, 1, 2)
    hat = taken @ np.linalg.inv(compared.variance(launch.scatter))
    solved = np.linalg.solve(np.eye(SIZE) - hat, compared.residual[..., None])
    return np.asarray(solved[..., 0])
