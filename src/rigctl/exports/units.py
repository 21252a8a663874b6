"""Units as other systems want them: apart from the name."""

from __future__ import annotations

RATIO = "1"
"""The unit of what has none."""

_ENDINGS = {
    **{unit: unit for unit in ("m", "mm", "s", "ms", "us", "deg", "rad")},
    "kpa": "kPa",
    "hz": "Hz",
    "c": "degC",
}


def unit_of(column: str) -> str:
    """Return the unit that a column's name ends in, 1 where it names none."""
    name, _, ending = column.rpartition("_")
    return _ENDINGS.get(ending, RATIO) if name else RATIO
