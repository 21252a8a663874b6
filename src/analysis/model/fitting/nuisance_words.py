"""What a fit makes of its nuisances, in words; the page says it without the model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from analysis.quantity import Quantity

Json = dict[str, Any]


def alarm_sentences(alarms: Sequence[Json]) -> list[str]:
    """Say what alarms mean, all of them in one sentence; none without an alarm."""
    if not alarms:
        return []
    first, others = alarms[0], alarms[1:]
    stated, found = (_with_unit(first[key]) for key in ("stated", "found"))
    also = ", ".join(f"{one['nuisance']} {abs(one['pull']):.1f}" for one in others)
    beside = f" ({also} of theirs)" if others else ""
    it, is_ = ("they", "they are") if others else ("it", "it is")
    return [
        f"Alarm: {first['nuisance']} is stated as {stated}, and the fit pulls it to {found}, "
        f"{abs(first['pull']):.1f} of its stated errors away{beside}: the law lacks something "
        f"that {it} {'make' if others else 'makes'} up for, or {is_} stated wrongly. Add what is "
        f"missing, or measure {'them' if others else 'it'} anew."
    ]


def nuisance_lines(nuisances: Sequence[Json]) -> list[str]:
    """Say what a fit makes of all that is stated beforehand, a line for each."""
    return [
        f"{one['nuisance']} = {_with_unit(one['found'])} (fitted beside it, stated "
        f"{_with_unit(one['stated'])})"
        for one in nuisances
    ]


def _with_unit(quantity: Json) -> str:
    value, sigma, unit = quantity["value"], quantity["sigma"], quantity["unit"]
    return Quantity(value, sigma, unit).concise() + ("" if unit == "1" else f" {unit}")
