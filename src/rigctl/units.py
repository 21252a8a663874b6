"""Units as they stand at the end of a name, apart from it."""

from __future__ import annotations

RATIO = "1"
"""The unit of what has none."""

_PER = "_per_"
_ENDINGS = {
    **{unit: unit for unit in ("m", "mm", "s", "ms", "us", "deg", "rad", "px", "kg", "m3", "s2")},
    "kpa": "kPa",
    "pa": "Pa",
    "hz": "Hz",
    "c": "degC",
    "rpm": "rpm",
    "mb": "MB",
    "kb": "kB",
}


def unit_of(name: str) -> str:
    """Return the unit that a name ends in, as `scale_px_per_m` does; 1 where it names none."""
    above, per, below = name.rpartition(_PER)
    if per:
        return f"{unit_of(above)}/{_ENDINGS[below]}" if below in _ENDINGS else RATIO
    stem, _, ending = name.rpartition("_")
    return _ENDINGS.get(ending, RATIO) if stem else RATIO
