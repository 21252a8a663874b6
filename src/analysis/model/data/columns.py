"""What shots.csv says of the shots of a campaign, as columns of numbers."""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.exchange.shot_list import EXPOSURE, WORDS, ShotRow

ORDER = "order"


class ShotColumns:
    """Numbers and times of the shots of a campaign, eight bytes for each.

    Attributes
    ----------
    excluded
        Numbers of the shots that a person left out.
    """

    def __init__(self, rows: Iterable[ShotRow] = ()) -> None:
        self.excluded = set[int]()
        self._shots, self._times = array("q"), array("d")
        self._columns: dict[str, array[float]] = {}
        self._worded = set[str]()
        for row in rows:
            self.add(row)

    def add(self, row: ShotRow) -> None:
        """Add what is known of one shot."""
        count = len(self._shots)
        self._shots.append(row.shot)
        self._times.append(math.nan if row.time is None else row.time.timestamp())
        for name in sorted(row.numbers.keys() - self._columns.keys()):
            self._columns[name] = array("d", [math.nan]) * count
        for name, column in self._columns.items():
            column.append(row.numbers.get(name, math.nan))
        self._worded |= row.words.keys() - WORDS
        if row.is_excluded:
            self.excluded.add(row.shot)

    def covariates(self, numbers: NDArray[np.intp]) -> dict[str, Floats]:
        """Return the order of firing and every numeric column that all these shots have, (S,)."""
        places, known = self._places(numbers)
        columns = self._columns if known.all() else {}
        found = {name: np.asarray(column)[places] for name, column in columns.items()}
        covariates = {name: column for name, column in found.items() if not np.isnan(column).any()}
        times = np.asarray(self._times)[places] if known.all() else np.array([math.nan])
        # Where not every time is known, the order is that of the numbers.
        order = np.argsort(numbers if np.isnan(times).any() else times, kind="stable")
        rank = np.empty(len(numbers))
        rank[order] = np.arange(len(numbers))
        covariates[ORDER] = rank / max(len(numbers) - 1, 1) - 0.5
        return covariates

    def unused(self, numbers: NDArray[np.intp]) -> dict[str, str]:
        """Return the columns that are no covariates of these shots, each with the reason."""
        known = self.covariates(numbers).keys()
        gaps = dict.fromkeys(self._columns.keys() - known, "empty in some shots")
        return {**gaps, **dict.fromkeys(sorted(self._worded), "holds words")}

    def exposure_s(self, numbers: NDArray[np.intp]) -> float | None:
        """Return the longest exposure of these shots, s; None where none is stated."""
        column = self._columns.get(EXPOSURE)
        if column is None:
            return None
        places, known = self._places(numbers)
        exposures = np.asarray(column)[places[known]]
        stated = exposures[~np.isnan(exposures)]
        return float(stated.max()) * 1e-6 if stated.size else None

    def _places(self, numbers: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
        """Return the rows of these shots, shape (S,), and which of them have one."""
        shots = np.asarray(self._shots)
        if len(shots) == 0:
            return np.zeros(len(numbers), dtype=np.intp), np.zeros(len(numbers), dtype=np.bool_)
        order = np.argsort(shots, kind="stable")
        at = np.minimum(np.searchsorted(shots[order], numbers), len(shots) - 1)
        places = order[at]
        return places, np.asarray(shots[places] == numbers)
