"""Which waiting step tells most about a coefficient, by what the shots before it have told."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rigctl.settings import ShotSettings

SPREAD = 8
"""Distinct settings fired in the sweep's own order before anything is chosen."""

WIDTH = 0.2
"""Range over which a shot speaks for its neighbours, as a share of the sweep's own range."""

Place = tuple[float, float, float]


def best(waiting: Sequence[ShotSettings], told: Sequence[tuple[ShotSettings, float]]) -> int:
    """Return the index of the waiting settings with the highest expected information.

    Information is 1 / sigma^2 of the coefficient from one shot, and 0 of one that could not be
    measured. What is expected of settings is the mean over all shots, weighted by a Gaussian of
    their distance with each setting scaled to its range in the sweep. The first comes first among
    equals, and as long as fewer than `SPREAD` distinct settings have been measured.

    Parameters
    ----------
    waiting
        Settings of the steps that wait, in the sweep's order; at least one.
    told
        Settings of each shot whose analysis has ended, and its information.
    """
    if len({_place(settings) for settings, _ in told}) < SPREAD:
        return 0
    scale = _scale([_place(settings) for settings in waiting] + [_place(s) for s, _ in told])
    expected = [_expected(_place(settings), told, scale) for settings in waiting]
    return max(range(len(waiting)), key=lambda k: (expected[k], -k))


def _expected(place: Place, told: Sequence[tuple[ShotSettings, float]], scale: Place) -> float:
    near = [
        (math.exp(-0.5 * (_distance(place, _place(settings), scale) / WIDTH) ** 2), information)
        for settings, information in told
    ]
    total = math.fsum(weight for weight, _ in near)
    return math.fsum(weight * information for weight, information in near) / total if total else 0.0


def _place(settings: ShotSettings) -> Place:
    return settings.pressure_a_kpa, settings.pressure_b_kpa, settings.offset_mm


def _scale(places: Sequence[Place]) -> Place:
    a, b, offset = (max(axis) - min(axis) or 1.0 for axis in zip(*places, strict=True))
    return a, b, offset


def _distance(one: Place, other: Place, scale: Place) -> float:
    return math.hypot(*((x - y) / s for x, y, s in zip(one, other, scale, strict=True)))
