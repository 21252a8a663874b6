"""What shots were measured to be, kept for all pages: a result on disk never changes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from rigctl.errors import RigError
from rigctl.store import ShotRecord, ShotState, Store

MOST_KEPT = 20_000
WORDS = ("", "sigma of ")


@dataclass(frozen=True, slots=True)
class Impact:
    """The coefficients of a measured shot, each a value and its standard error.

    `v_n` and `v_s` are before contact, m/s; `e` and `beta` are ratios. A coefficient that the shot
    does not tell is None.
    """

    number: int
    v_n: tuple[float, float] | None
    v_s: tuple[float, float] | None
    e: tuple[float, float] | None
    beta: tuple[float, float] | None

    @property
    def incidence(self) -> float | None:
        """v_s / |v_n| before contact; None where either is not measured."""
        if self.v_n is None or self.v_s is None or not self.v_n[0]:
            return None
        return self.v_s[0] / abs(self.v_n[0])


def rows_of(impacts: Iterable[Impact]) -> list[list[object]]:
    """Return coefficients as rows of a CSV, its heading first; what a shot does not tell is empty.

    Velocities in m/s.
    """
    names = ("v_n", "v_s", "e", "beta")
    rows: list[list[object]] = [["shot", *(f"{word}{name}" for name in names for word in WORDS)]]
    for one in impacts:
        told = [getattr(one, name) or ("", "") for name in names]
        rows.append([one.number, *(part for pair in told for part in pair)])
    return rows


FEWEST_EACH = 3
"""Shots whose sliding turns round, and shots whose sliding goes on, that tell where it changes."""


def turns_until(impacts: Iterable[Impact]) -> float | None:
    """Return the ratio v_s / v_n up to which friction turns the sliding round, by measured shots.

    The ratio that parts shots with beta > 0 from those with beta < 0 with the fewest on the wrong
    side. None where there are too few of either: friction decides it, and no setting tells that.
    """
    told = sorted(
        (one.incidence, one.beta[0])
        for one in impacts
        if one.incidence is not None and one.beta is not None and abs(one.beta[0]) > one.beta[1]
    )
    turned = sum(beta > 0 for _, beta in told)
    if min(turned, len(told) - turned) < FEWEST_EACH:
        return None
    # On the wrong side of a place before all: every shot that is turned round.
    wrong, least, best = turned, len(told) + 1, 0.0
    for (here, beta), (there, _) in pairwise(told):
        wrong += -1 if beta > 0 else 1
        if wrong < least:
            least, best = wrong, (here + there) / 2
    return best


class Readings:
    """Reads results once. Any thread may call it; it blocks for the disk."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._known: dict[tuple[str, int], Impact | None] = {}

    def of(self, shots: Iterable[ShotRecord]) -> list[Impact]:
        """Return what those of the shots that are measured were measured to be, in their order."""
        found = (self._one(shot) for shot in shots if shot.state is ShotState.ANALYSED)
        return [impact for impact in found if impact is not None]

    def _one(self, shot: ShotRecord) -> Impact | None:
        key = shot.id, shot.results
        if key not in self._known:
            while len(self._known) >= MOST_KEPT:
                del self._known[next(iter(self._known))]
            self._known[key] = self._read(shot)
        return self._known[key]

    def _read(self, shot: ShotRecord) -> Impact | None:
        try:
            result = self._store.result(shot.id, shot.results)
        except RigError:
            return None
        if result.get("status") != "measured":
            return None
        told = {name: _told(result.get(name)) for name in ("v_n", "v_s", "e", "beta")}
        return Impact(shot.number, **told)


def _told(quantity: Mapping[str, Any] | None) -> tuple[float, float] | None:
    if quantity is None or quantity.get("sigma") is None:
        return None
    return float(quantity["value"]), float(quantity["sigma"])
