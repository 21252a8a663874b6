"""A measured number with its standard error and unit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Real
from typing import Annotated, Any

import numpy as np
from pydantic import PlainSerializer, PlainValidator

from analysis.arrays import Floats


def own_part(sigma: Floats | float, common: Floats | float) -> Floats:
    """Return the part of standard errors that is each shot's own, beside what all shots share."""
    return np.asarray(np.sqrt(np.clip(np.square(sigma) - np.square(common), 0.0, None)))


@dataclass(frozen=True, slots=True)
class Quantity:
    """A value, its standard error, and the unit of both.

    Attributes
    ----------
    common
        Part of the error that all shots of a campaign share, which a mean of many does not reduce:
        sigma^2 = own^2 + common^2. None where the two parts are not separated.
    """

    value: float
    sigma: float
    unit: str
    common: float | None = None

    @classmethod
    def undetermined(cls, unit: str) -> Quantity:
        """Return a quantity without a value."""
        return cls(math.nan, math.inf, unit)

    @property
    def determined(self) -> bool:
        """Whether it has a value."""
        return math.isfinite(self.value)

    @property
    def own(self) -> float | None:
        """Return the part of the error that is this shot's own; None where not separated."""
        return None if self.common is None else float(own_part(self.sigma, self.common))

    def rescaled(self, factor: float, unit: str) -> Quantity:
        """Return the same quantity in another unit: `factor` of these are one of the present."""
        common = None if self.common is None else factor * self.common
        return Quantity(factor * self.value, factor * self.sigma, unit, common)

    @classmethod
    def from_json(cls, document: Mapping[str, Any]) -> Quantity:
        """Return the quantity that a document holds; null is what is not determined.

        Raises
        ------
        ValueError
            It is no mapping, a key is missing, the unit is no text, a number is none or not finite,
            or a standard error is less than 0.
        """
        if not isinstance(document, Mapping):
            raise ValueError(f"{document!r} is no quantity with value, sigma and unit")
        if missing := [key for key in ("value", "sigma", "unit") if key not in document]:
            raise ValueError(f"a quantity lacks {' and '.join(missing)}")
        unit = document["unit"]
        if not isinstance(unit, str):
            raise ValueError(f"unit: {unit!r} is no text")
        value, sigma, common = (_number(document, k) for k in ("value", "sigma", "sigma_common"))
        if value is None:
            return cls.undetermined(unit)
        return _checked(cls(value, math.inf if sigma is None else sigma, unit, common))

    def to_json(self) -> dict[str, float | str | None]:
        """Return the form of the exchange documents; what is not determined is null."""
        if not self.determined:
            return {"value": None, "sigma": None, "unit": self.unit}
        sigma = self.sigma if math.isfinite(self.sigma) else None
        document: dict[str, float | str | None] = {"value": self.value, "sigma": sigma}
        if self.common is not None and sigma is not None:
            document |= {"sigma_own": self.own, "sigma_common": self.common}
        return {**document, "unit": self.unit}

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


def _number(document: Mapping[str, Any], key: str) -> float | None:
    given = document.get(key)
    if given is None:
        return None
    # True is a number to Python, and a whole number may be beyond every float.
    plain = isinstance(given, Real) and not isinstance(given, bool)
    try:
        number = float(given) if plain else math.nan
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise ValueError(f"{key}: {given!r} is no finite number")
    return number


def _checked(quantity: Quantity) -> Quantity:
    """Return a quantity; raise `ValueError` where an error of what is determined can be none."""
    if quantity.determined:
        for name, sigma in (("sigma", quantity.sigma), ("sigma_common", quantity.common)):
            if sigma is not None and not sigma >= 0:
                raise ValueError(f"{name}: {sigma!r} {quantity.unit} is no standard error")
    return quantity


def _read(value: Any) -> Quantity:  # noqa: ANN401 - a document holds anything
    return _checked(value) if isinstance(value, Quantity) else Quantity.from_json(value)


Measured = Annotated[Quantity, PlainValidator(_read), PlainSerializer(Quantity.to_json)]
"""A quantity as a field of a document's model."""
