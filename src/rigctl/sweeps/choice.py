"""Which waiting step tells most about a coefficient, by what the shots before it have told."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rigctl.settings import ShotSettings

SPREAD = 8
"""Distinct settings measured in the sweep's own order before anything is chosen."""

WIDTH = 0.2
"""Range over which a shot speaks for its neighbours, as a share of the sweep's own range."""

PRIOR = 0.1
"""Weight of the plain mean of all shots, against 1 of a shot at the settings themselves."""


def best(waiting: Sequence[ShotSettings], told: Sequence[tuple[ShotSettings, float]]) -> int:
    """Return the index of the waiting settings with the highest expected information.

    Information is 1 / sigma^2 of the coefficient from one shot, and 0 of one that could not be
    measured. What is expected of settings is the mean over all shots, weighted by a Gaussian of
    their distance with each setting scaled to its range in the sweep; far from all shots it is
    their plain mean. The first comes first among equals, and as long as fewer than `SPREAD`
    distinct settings have been measured.

    Parameters
    ----------
    waiting
        Settings of the steps that wait, in the sweep's order; at least one.
    told
        Settings of each shot whose analysis has ended, and its information.
    """
    fired = _places([settings for settings, _ in told])
    if len(np.unique(fired, axis=0)) < SPREAD:
        return 0
    places = _places(waiting)
    ranges = np.ptp(np.concatenate([places, fired]), axis=0)
    ranges[ranges == 0.0] = 1.0
    apart = (places[:, None] - fired[None]) / ranges
    weights = np.exp(-0.5 * np.sum(apart**2, axis=2) / WIDTH**2)
    information = np.array([each for _, each in told])
    near = np.sum(weights, axis=1)
    expected = (weights @ information + PRIOR * np.mean(information)) / (near + PRIOR)
    # Rounding must not choose among equals.
    return int(np.argmax(expected >= np.max(expected) * (1.0 - 1e-9)))


def _places(settings: Sequence[ShotSettings]) -> NDArray[np.float64]:
    """Return the settings as points (n, 3)."""
    points = [(each.pressure_a_kpa, each.pressure_b_kpa, each.offset_mm) for each in settings]
    return np.array(points, dtype=np.float64).reshape(-1, 3)
