"""Values that a setting takes in a grid: a list, or a range with a spacing."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Discriminator, Field, Tag, model_validator

from rigctl.config.model import StrictModel

MOST_LEVELS = 1000

Spacing = Literal["linear", "logarithmic", "root"]


class Range(StrictModel):
    """Values from `first` to `last`, both included.

    `linear` spaces the values evenly, `logarithmic` their logarithms, `root` their square roots:
    pressures so spaced give speeds at even distances.
    """

    first: float = Field(description="first value")
    last: float = Field(description="last value")
    count: int = Field(ge=2, le=MOST_LEVELS, description="how many values")
    spacing: Spacing = Field(default="linear", description="what is spaced evenly")

    @model_validator(mode="after")
    def _can_be_spaced(self) -> Self:
        if self.first == self.last:
            raise ValueError(f"a range from {self.first:g} to {self.last:g} is empty")
        least = min(self.first, self.last)
        if self.spacing == "logarithmic" and least <= 0:
            raise ValueError(f"spacing 'logarithmic' needs values above 0, the least is {least:g}")
        if self.spacing == "root" and least < 0:
            raise ValueError(f"spacing 'root' needs values of at least 0, the least is {least:g}")
        return self

    def values(self) -> list[float]:
        """Return the values in order; the ends are exact."""
        shares = [k / (self.count - 1) for k in range(1, self.count - 1)]
        return [self.first, *(self._between(share) for share in shares), self.last]

    def _between(self, share: float) -> float:
        if self.spacing == "logarithmic":
            return float(self.first ** (1 - share) * self.last**share)
        if self.spacing == "root":
            return float((self.first**0.5 * (1 - share) + self.last**0.5 * share) ** 2)
        return self.first * (1 - share) + self.last * share


def _form(value: object) -> str:
    return "range" if isinstance(value, dict | Range) else "list"


def _each_once(values: list[float]) -> list[float]:
    for position, value in enumerate(values):
        if value in values[:position]:
            raise ValueError(f"{value:g} stands twice; use `repeat` to fire it more often")
    return values


Listed = Annotated[
    list[float], Field(min_length=1, max_length=MOST_LEVELS), AfterValidator(_each_once)
]
Levels = Annotated[
    Annotated[Listed, Tag("list")] | Annotated[Range, Tag("range")], Discriminator(_form)
]
"""A list of values, or a table that spaces them."""


def values_of(levels: Levels) -> list[float]:
    """Return the values of either form, in order."""
    return levels.values() if isinstance(levels, Range) else list(levels)
