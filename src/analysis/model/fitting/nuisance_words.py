"""What a fit makes of its nuisances, in words; the page says it without the model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from analysis.quantity import Quantity

Json = dict[str, Any]


def alarm_sentence(alarm: Json) -> str:
    """Say what an alarm means."""
    stated, found = (_with_unit(alarm[key]) for key in ("stated", "found"))
    return (
        f"Alarm: {alarm['nuisance']} is stated as {stated}, and the fit pulls it to {found}, "
        f"{abs(alarm['pull']):.1f} of its stated errors away: the law lacks something that it "
        "makes up for, or it is stated wrongly. Add what is missing, or measure it anew."
    )


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
