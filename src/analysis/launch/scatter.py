"""How much a launch varies from shot to shot beyond what the measurement's errors explain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from analysis.arrays import Floats
from analysis.launch.muzzle import SIZE, SPEED


@dataclass(frozen=True, slots=True)
class Kind:
    """Numbers of a muzzle that scatter alike.

    Attributes
    ----------
    name, unit
        As a table shows it; in that unit a number is `factor` times its SI value.
    columns
        Their indices in the row of a muzzle.
    relative
        They scatter in proportion to the speed.
    """

    name: str
    unit: str
    columns: tuple[int, ...]
    factor: float = 1.0
    relative: bool = False


KINDS = (
    Kind("speed", "m/s", (0, 1), relative=True),
    Kind("slope X", "rad", (2, 4)),
    Kind("slope Z", "rad", (3, 5)),
    Kind("spin X", "rad/s", (6, 9)),
    Kind("spin Y", "rad/s", (7, 10)),
    Kind("spin Z", "rad/s", (8, 11)),
    Kind("track offset X", "mm", (12,), 1e3),
    Kind("track offset Z", "mm", (13,), 1e3),
    Kind("track height X", "mm", (14,), 1e3),
    Kind("track height Z", "mm", (15,), 1e3),
    Kind("lag", "us", (16,), 1e6),
)
"""The quantities of a launch; a and b share a kind, as their pushers are alike."""


def scatter_shape(column: int, speed: Floats) -> Floats:
    """Return what the scatter of a column is proportional to, shape (S,): its speed, or one.

    `speed` in m/s, shape (S, 2).
    """
    moving = SPEED.start <= column < SPEED.stop
    return speed[:, column] if moving else np.ones(len(speed))


def scatter_variance(scatter: Floats, speed: Floats) -> Floats:
    """Return the variance of each number of a muzzle, shape (S, 17), for scatters (K,)."""
    variance = np.zeros((len(speed), SIZE))
    for kind, s in zip(KINDS, scatter, strict=True):
        for column in kind.columns:
            variance[:, column] = (s * scatter_shape(column, speed)) ** 2
    return variance


def variance_component(residual: Floats, variance: Floats, shape: Floats, freedom: float) -> float:
    """Return the scatter s >= 0 at which sum r^2 / (C + s^2 k^2) equals the degrees of freedom.

    R. C. Paule and J. Mandel, J. Res. Natl. Bur. Stand. 87, 377 (1982): moments alone, no shape of
    the distribution.

    Parameters
    ----------
    residual, variance
        Residuals and the variances C of their measurement, shape (N,).
    shape
        The scatter's standard deviation in units of s, shape (N,).
    freedom
        Degrees of freedom, above zero.
    """

    def excess(s: float) -> float:
        return float((residual**2 / (variance + (s * shape) ** 2)).sum()) - freedom

    if excess(0.0) <= 0.0:
        return 0.0
    most = float(np.sqrt(((residual / shape) ** 2).sum() / freedom))
    return float(brentq(excess, 0.0, most, xtol=1e-9 * most))
