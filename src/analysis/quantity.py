"""A measured number that never travels without its error."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Quantity:
    """A value, its standard error, and the unit of both."""

    value: float
    sigma: float
    unit: str

    @classmethod
    def undetermined(cls, unit: str) -> Quantity:
        """Return a quantity of which nothing is known."""
        return cls(math.nan, math.inf, unit)

    @property
    def determined(self) -> bool:
        """Whether anything is known of it."""
        return math.isfinite(self.value)

    def rescaled(self, factor: float, unit: str) -> Quantity:
        """Return the same quantity in a unit of which `factor` make one of its own."""
        return Quantity(factor * self.value, factor * self.sigma, unit)

    def to_json(self) -> dict[str, float | str | None]:
        """Return the form of the exchange documents; what is not determined is null."""
        if not self.determined:
            return {"value": None, "sigma": None, "unit": self.unit}
        return {"value": self.value, "sigma": self.sigma, "unit": self.unit}

    def concise(self) -> str:
        """Return the value with its error in brackets, 0.7384(33): in units of the last digit.

        Two digits of the error are kept (GUM, JCGM 100:2008, section 7.2.2).
        """
        if not self.determined:
            return "not determined"
        if not (math.isfinite(self.sigma) and self.sigma > 0):
            return f"{self.value:g}"
        decimals = max(0, 1 - math.floor(math.log10(self.sigma)))
        digits = round(self.sigma * 10**decimals)
        return f"{self.value:.{decimals}f}({digits})"
