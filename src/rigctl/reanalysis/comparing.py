"""Two results of the same shots, side by side."""

from __future__ import annotations

import math
from dataclasses import dataclass

from analysis.quantity import Quantity
from rigctl.reanalysis.campaign import Outcome

QUANTITIES = ("v_n", "v_s", "v_n_after", "v_s_after", "e", "beta", "contact_duration")


@dataclass(frozen=True, slots=True)
class Comparison:
    """How one quantity changed over the shots that both results measure.

    Attributes
    ----------
    shots
        How many.
    mean, rms
        Of the differences, later minus earlier, in `unit`.
    rms_sigmas
        Root mean square of the differences, each in units of its own standard error, the two
        taken as independent: they see the same frames, so that less than 1 is to be expected.
    """

    quantity: str
    unit: str
    shots: int
    mean: float
    rms: float
    rms_sigmas: float | None


class Comparisons:
    """Compares results before with those that were added, shot by shot; keeps sums alone."""

    def __init__(self) -> None:
        self._sums = {quantity: _Sums() for quantity in QUANTITIES}

    def add(self, outcome: Outcome) -> None:
        """Take up a shot; one without both results has nothing to compare."""
        if outcome.before is None or outcome.after is None:
            return
        for quantity, sums in self._sums.items():
            before, after = outcome.before.get(quantity), outcome.after.get(quantity)
            if before is not None and after is not None:
                sums.add(Quantity.from_json(before), Quantity.from_json(after))

    def found(self) -> list[Comparison]:
        """Return how each quantity changed that both results of any shot have."""
        return [sums.comparison(name) for name, sums in self._sums.items() if sums.shots > 0]


@dataclass(slots=True)
class _Sums:
    """Of the differences d of one quantity, of d², and of (d / its standard error)²."""

    unit: str = ""
    shots: int = 0
    stated: int = 0
    difference: float = 0.0
    squared: float = 0.0
    weighted: float = 0.0

    def add(self, before: Quantity, after: Quantity) -> None:
        if not (before.determined and after.determined):
            return
        difference = after.value - before.value
        variance = before.sigma**2 + after.sigma**2
        self.unit = self.unit or before.unit
        self.shots += 1
        self.difference += difference
        self.squared += difference**2
        if 0 < variance < math.inf:
            self.stated += 1
            self.weighted += difference**2 / variance

    def comparison(self, quantity: str) -> Comparison:
        return Comparison(
            quantity,
            self.unit,
            self.shots,
            mean=self.difference / self.shots,
            rms=math.sqrt(self.squared / self.shots),
            rms_sigmas=math.sqrt(self.weighted / self.stated) if self.stated else None,
        )
