"""Units as parameters state them, and the dimensions they have."""

from __future__ import annotations

import re
from dataclasses import dataclass

_BASE: dict[str, tuple[float, float, float, float]] = {
    "1": (0, 0, 0, 0),
    "rad": (0, 0, 0, 0),
    "m": (1, 0, 0, 0),
    "s": (0, 1, 0, 0),
    "kg": (0, 0, 1, 0),
    "K": (0, 0, 0, 1),
    "N": (1, -2, 1, 0),
    "J": (2, -2, 1, 0),
    "Pa": (-1, -2, 1, 0),
    "Hz": (0, -1, 0, 0),
    "mm": (1, 0, 0, 0),
    "kPa": (-1, -2, 1, 0),
}
"""SI without prefixes, and the units in which a shot list states its settings."""
_FACTOR = re.compile(r"(?P<symbol>1|[A-Za-z]+|\([^()]*\))(\^(?P<power>-?\d+(\.\d+)?))?")

FORM = f"products and powers of {', '.join(_BASE)}, as in m/s^2, kg m/s or (m/s)^-0.2"


@dataclass(frozen=True, slots=True)
class Dimension:
    """Exponents of length, time, mass and temperature; an angle has none."""

    exponents: tuple[float, float, float, float]

    @classmethod
    def of(cls, unit: str) -> Dimension:
        """Return the dimension of a unit.

        Raises
        ------
        ValueError
            The unit is none that is known, or is not written in the known form.
        """
        above, *below = _split(unit)
        if len(below) > 1:
            raise ValueError(f"{unit!r} is divided more than once")
        total = _product(above)
        if below:
            total = _sum(total, _product(below[0]), -1.0)
        return cls(total)

    def __str__(self) -> str:
        """Return it in base units, `m s^-2`."""
        parts = [
            symbol if power == 1 else f"{symbol}^{power:.3g}"
            for symbol, power in zip(("m", "s", "kg", "K"), self.exponents, strict=True)
            if power != 0
        ]
        return " ".join(parts) or "1"


Exponents = tuple[float, float, float, float]


def _split(unit: str) -> list[str]:
    """Return the parts of a quotient; a stroke within brackets belongs to its factor."""
    return re.split(r"/(?![^(]*\))", unit)


def _product(text: str) -> Exponents:
    total: Exponents = (0.0, 0.0, 0.0, 0.0)
    for factor in re.split(r" (?![^(]*\))", text):
        found = _FACTOR.fullmatch(factor)
        if found is None:
            raise ValueError(f"{factor!r} is no unit")
        symbol, power = found["symbol"], float(found["power"] or 1.0)
        if symbol.startswith("("):
            inner = Dimension.of(symbol[1:-1]).exponents
        elif symbol in _BASE:
            inner = _BASE[symbol]
        else:
            raise ValueError(f"{symbol!r} is no unit that is known")
        total = _sum(total, inner, power)
    return total


def _sum(first: Exponents, second: Exponents, times: float) -> Exponents:
    length, time, mass, temperature = (a + times * b for a, b in zip(first, second, strict=True))
    return length, time, mass, temperature
