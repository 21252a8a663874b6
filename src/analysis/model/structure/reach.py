"""Over which times and places smooth functions of a frame run: 1 to 99 per cent of those measured.

Both quantiles are exact in a campaign of any length: of all its frames only the outermost are kept.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.model.data.stream import CampaignData
from analysis.model.data.tables import ContactTable
from analysis.model.fitting.fit import Fit, parts_of
from analysis.model.predict.prediction import predict

TIME = "time"
SHARE = 0.01
LEAST_WIDTH = 1e-9


@dataclass(frozen=True, slots=True)
class Interval:
    """From which place on and up to which a smooth function runs."""

    low: float
    high: float

    def places(self, values: Floats) -> Floats:
        """Return places with the ends at -1 and 1."""
        width = max(self.high - self.low, LEAST_WIDTH)
        return 2 * (values - self.low) / width - 1

    def scaled(self, values: Floats) -> Floats:
        """Return the same with all that lies beyond the ends at them."""
        return np.clip(self.places(values), -1.0, 1.0)


@dataclass(frozen=True, slots=True)
class Reach:
    """The intervals of the time from contact, s, and of X, Y and Z in the field, m."""

    time: Interval
    field: tuple[Interval, Interval, Interval]

    def of(self, covariate: str) -> Interval:
        """Return that of a covariate: `time`, or `field X` and so on."""
        return self.time if covariate == TIME else self.field["XYZ".index(covariate[-1])]


def reach_of(data: CampaignData, fit: Fit) -> Reach:
    """Return the reach of all frames of a campaign; a table of contacts has none."""
    longest = Outermost(0)
    if isinstance(data, ContactTable):
        return Reach(longest.interval(), (longest.interval(),) * 3)
    frames = next(iter(data.parts())).times_s.shape[1] * len(data.shots)
    longest, field = Outermost(frames), [Outermost(2 * frames) for _ in range(3)]
    for part, states in parts_of(data, fit):
        assert not isinstance(part, ContactTable)  # noqa: S101
        tau = part.times_s - states.time_s[:, None]
        longest.add(np.abs(tau[part.measured.any(axis=(2, 3))]))
        position = predict(part, states, fit.theory).position
        used = np.isfinite(part.position_sigma).any(axis=-1)
        for along, places in enumerate(field):
            places.add(position[used, along])
    end = longest.interval().high
    x, y, z = (places.interval() for places in field)
    return Reach(Interval(-end, end), (x, y, z))


class Outermost:
    """The outermost of many numbers that come part by part.

    Parameters
    ----------
    most
        How many numbers there are at most.
    """

    def __init__(self, most: int) -> None:
        self._kept = int(SHARE * most) + 2
        self._low, self._high, self._count = np.zeros(0), np.zeros(0), 0

    def add(self, values: Floats) -> None:
        """Take in more numbers."""
        self._count += values.size
        self._low = np.sort(np.concatenate([self._low, values]))[: self._kept]
        self._high = np.sort(np.concatenate([self._high, values]))[-self._kept :]

    def interval(self) -> Interval:
        """Return the 1 and 99 per cent quantiles of all; 0 and 0 of none."""
        if self._count == 0:
            return Interval(0.0, 0.0)
        return Interval(self._inward(self._low), self._inward(self._high[::-1]))

    def _inward(self, ordered: Floats) -> float:
        """Return the quantile counted from the outermost of one end."""
        whole, rest = divmod(SHARE * (self._count - 1), 1.0)
        first = ordered[int(whole)]
        following = ordered[min(int(whole) + 1, len(ordered) - 1)]
        return float(first + rest * (following - first))
