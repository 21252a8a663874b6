"""The fitted states of a campaign as measurements of its launches, with their covariance."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.errors import LaunchRefusedError
from analysis.launch.touch import Ground, observed_touch, touch_by_state
from analysis.model.data.tables import ContactTable, Data
from analysis.model.fitting.fit import Fit, normal_equations

_WIDEST = np.array([1.0] * 4 + [3.0] * 2 + [1e2] * 6 + [1e4] * 6 + [3.0] * 6)
"""What no shot can exceed, in the units of a state: the error of a number that was not measured."""


@dataclass(frozen=True, slots=True, eq=False)
class Touches:
    """First touches of S shots as measured.

    Attributes
    ----------
    shots
        Numbers of the shots, shape (S,).
    rows, covariance
        Numbers as `touch` has them, shape (S, 17), and their covariances, shape (S, 17, 17).
    time_s
        Instants from the shots' first frames, shape (S,).
    ground
        Spheres and gravity.
    """

    shots: NDArray[np.intp]
    rows: Floats
    covariance: Floats
    time_s: Floats
    ground: Ground

    def of_shots(self, chosen: NDArray[np.bool_]) -> Touches:
        """Return the touches of some shots, mask of shape (S,)."""
        names = ("shots", "rows", "covariance", "time_s")
        return replace(self, **{name: getattr(self, name)[chosen] for name in names})


def measured_touches(data: Data, fit: Fit) -> Touches:
    """Return every shot's state at first touch by a fit of the poses.

    The covariance is the inverse of each shot's own normal equations, A^-1, in units of the noise
    as it was found. What the errors of e, mu and beta0 add, alike in all shots, is left out: the
    state before contact is measured before contact.

    Raises
    ------
    LaunchRefusedError
        The data are a table of contacts, which lacks time and place of first touch.
    """
    if isinstance(data, ContactTable):
        raise LaunchRefusedError("a table of contacts does not say where and when spheres met")
    information = normal_equations(data, fit.states, fit.theory).states / max(
        fit.chi2_per_dof, 1e-12
    )
    scaled = information * _WIDEST[:, None] * _WIDEST + np.eye(len(_WIDEST))
    covariance = np.linalg.inv(scaled) * _WIDEST[:, None] * _WIDEST
    derivative = touch_by_state(fit.states)
    return Touches(
        shots=data.shots,
        rows=observed_touch(fit.states),
        covariance=derivative @ covariance @ np.swapaxes(derivative, 1, 2),
        time_s=fit.states.time_s,
        ground=Ground(data.bodies, data.gravity),
    )
