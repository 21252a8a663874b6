"""A measured number that never travels without its error."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Quantity:
    """A value, its standard error, and the unit of both."""

    value: float
    sigma: float
    unit: str

    def to_json(self) -> dict[str, float | str]:
        """Return the form of the exchange documents."""
        return {"value": self.value, "sigma": self.sigma, "unit": self.unit}

    def __str__(self) -> str:
        return f"{self.value:.4g} +- {self.sigma:.2g} {self.unit}".rstrip(" 1").rstrip()
