"""A coefficient from the measured shots of a sweep: each shot's word, and their mean."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rigctl.errors import NotFoundError
from rigctl.store import ShotRecord, ShotState, Store

FEWEST = 3
"""Shots below which a mean has no standard error: their scatter is too uncertain."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value with its standard error, in the coefficient's own unit (1).

    Attributes
    ----------
    own, common
        Parts of the error: the shot's own, and what it shares with all shots.
    """

    value: float
    own: float
    common: float = 0.0


@dataclass(frozen=True, slots=True)
class Mean:
    """The weighted mean over measured shots.

    Attributes
    ----------
    own
        Its standard error by the shots' own errors; None with fewer than three shots.
    common
        That by what all shots share, which more of them do not reduce.
    shots
        How many shots it rests on.
    """

    coefficient: str
    value: float
    own: float | None
    common: float
    shots: int

    @property
    def sigma(self) -> float | None:
        """Its standard error, both parts together."""
        return None if self.own is None else math.hypot(self.own, self.common)


def mean_of(coefficient: str, estimates: list[Estimate]) -> Mean | None:
    """Return the mean of estimates, weighted by 1 / own^2; None without any.

    The error of the shots' own is (sum of the weights)^(-1/2), multiplied by Birge's ratio
    sqrt(chi^2 / (n - 1)) where that exceeds 1, the Birge ratio (R. T. Birge, Phys. Rev. 40 (1932)
    207, eq. 2). An error that all shots share moves their mean as well: no number of shots makes
    it smaller.
    """
    if not estimates:
        return None
    weights = [estimate.own**-2 for estimate in estimates]
    total = math.fsum(weights)
    value = math.fsum(w * each.value for w, each in zip(weights, estimates, strict=True)) / total
    shared = math.fsum(w * x.common for w, x in zip(weights, estimates, strict=True)) / total
    if len(estimates) < FEWEST:
        return Mean(coefficient, value, None, shared, len(estimates))
    chi2 = math.fsum(
        w * (each.value - value) ** 2 for w, each in zip(weights, estimates, strict=True)
    )
    birge = max(1.0, math.sqrt(chi2 / (len(estimates) - 1)))
    return Mean(coefficient, value, birge / math.sqrt(total), shared, len(estimates))


def estimate_in(result: Mapping[str, Any], coefficient: str) -> Estimate | None:
    """Return a coefficient by a shot's result; None where it has no usable error."""
    quantity = result.get(coefficient)
    if not isinstance(quantity, Mapping) or None in (quantity["value"], quantity["sigma"]):
        return None
    value, sigma = float(quantity["value"]), float(quantity["sigma"])
    # Results of versions that did not separate the parts have the whole error only.
    own, common = float(quantity.get("sigma_own", sigma)), float(quantity.get("sigma_common", 0.0))
    return Estimate(value, own, common) if math.isfinite(value) and 0.0 < own < math.inf else None


class Measured:
    """What the analysis has found so far: it listens for the ends of analyses, until `close`.

    Parameters
    ----------
    store
        Lists shots and holds their results; a result is read once.
    coefficient
        Which one.
    shots
        Those whose analysis may have ended before.
    """

    def __init__(self, store: Store, coefficient: str, shots: list[str]) -> None:
        self._store, self._coefficient = store, coefficient
        self._known: dict[str, Estimate | None] = {}
        self._ended: dict[str, ShotState] = {}
        self.close = store.listeners.add(self._note)
        for shot in shots:
            self._note(store.shot(shot))

    def of(self, shot: str) -> tuple[Estimate | None, bool]:
        """Return a shot's estimate, and whether its analysis has ended."""
        if shot not in self._ended:
            return None, False
        if shot not in self._known:
            measured = self._ended[shot] is ShotState.ANALYSED
            self._known[shot] = self._read(shot) if measured else None
        return self._known[shot], True

    def mean(self, shots: list[str]) -> Mean | None:
        """Return the mean over those of the shots that are measured."""
        found = (self.of(shot)[0] for shot in shots)
        return mean_of(self._coefficient, [each for each in found if each is not None])

    def _note(self, shot: ShotRecord) -> None:
        if shot.state in {ShotState.ANALYSED, ShotState.REFUSED}:
            self._ended[shot.id] = shot.state

    def _read(self, shot: str) -> Estimate | None:
        try:
            return estimate_in(self._store.result(shot), self._coefficient)
        except NotFoundError:
            return None
