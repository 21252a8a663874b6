"""How wrong velocities and spins of all shots may be together, by what measuring shares of them.

What all flights of a campaign share of errors (`SlowErrors.common_m`, `common_rad`) may change
along a flight: with the place in the field, or with the markers that are seen. The rate of a flight
is then wrong by as much as a straight line through a slow error can be, alike in shots that are
alike, and no scatter shows it.
"""

from __future__ import annotations

import math

import numpy as np

from analysis.arrays import Floats
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import PoseStream
from analysis.model.structure.channels import pairs_of
from analysis.model.structure.layout import AXES
from analysis.motion.drift import WORST_LENGTH, line_variances


def shared_rates(data: PoseData | PoseStream) -> dict[str, float]:
    """Return the size of each jump at contact, m/s or rad/s, that may be of the measurement.

    A jump is the change of a rate from one flight to the next, each flight of each sphere being
    wrong by itself.
    """
    worst = math.sqrt(float(line_variances(np.array(WORST_LENGTH))[1])) / flight_time_s(data)
    sizes = {"velocity": data.slow.common_m, "spin": data.slow.common_rad}
    first = next(iter(data.parts()))
    return {
        f"{word} {kind} {axis}": worst * size * _flights(shares)
        for kind, size in sizes.items()
        for word, shares in pairs_of(first)
        for axis in AXES
    }


def _flights(shares: tuple[float, float]) -> float:
    """Return the error of a jump of both spheres by these shares, of a flight's being 1."""
    own = np.array(shares)
    return math.sqrt(2.0 / float(own @ own))


def flight_time_s(data: PoseData | PoseStream) -> float:
    """Return for how long a typical flight is seen, s: half of the time of a typical shot."""
    spans: list[Floats] = []
    for part in data.parts():
        seen = part.seen
        first = np.where(seen, part.times_s, np.inf).min(axis=1)
        last = np.where(seen, part.times_s, -np.inf).max(axis=1)
        spans.append((last - first)[seen.any(axis=1)])
    return float(np.median(np.concatenate(spans))) / 2.0
