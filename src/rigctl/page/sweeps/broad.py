"""A sweep for whoever does not know yet what to look for: slow to fast, head on to grazing."""

from __future__ import annotations

from rigctl.config import Limits
from rigctl.sweeps.form import Sweep

SHOTS: dict[str, tuple[tuple[float, float], dict[str, object]]] = {
    "pressure_a_kpa": ((20.0, 80.0), {"count": 5, "spacing": "root"}),
    "offset_mm": ((0.0, 20.0), {"count": 6}),
}
"""Of the thirty shots: ends and number of values, from slow to fast, from head on to grazing."""


def broad_sweep(campaign: str, limits: Limits) -> Sweep | None:
    """Return thirty shots all over pressures and offsets, within the limits of the rig.

    None where the rig sets neither pressure nor offset.
    """
    levels: dict[str, object] = {}
    for name, (ends, how) in SHOTS.items():
        low, high = limits.offset_mm if name == "offset_mm" else limits.pressure_kpa
        first, last = (min(max(end, low), high) for end in ends)
        if first == last:
            return None
        levels[name] = {"first": first, "last": last, **how}
    return Sweep.model_validate(
        {"campaign": campaign, "grid": levels, "note": "slow to fast, head on to grazing"}
    )
