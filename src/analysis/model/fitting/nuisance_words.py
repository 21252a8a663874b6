"""What a fit makes of its nuisances, in words; the page says it without the model."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.quantity import Quantity
from analysis.schema.verdict import Nuisance


def alarm_sentences(alarms: Sequence[Nuisance]) -> list[str]:
    """Say what alarms mean, all of them in one sentence; none without an alarm."""
    if not alarms:
        return []
    first, others = alarms[0], alarms[1:]
    stated, found = _with_unit(first.stated), _with_unit(first.found)
    also = ", ".join(f"{one.name} {abs(one.pull):.1f}" for one in others)
    beside = f" ({also} of theirs)" if others else ""
    it, is_ = ("they", "they are") if others else ("it", "it is")
    return [
        f"Alarm: {first.name} is stated as {stated}, and the fit pulls it to {found}, "
        f"{abs(first.pull):.1f} of its stated errors away{beside}: the law lacks something "
        f"that {it} {'make' if others else 'makes'} up for, or {is_} stated wrongly. Add what is "
        f"missing, or measure {'them' if others else 'it'} anew."
    ]


def nuisance_lines(nuisances: Sequence[Nuisance]) -> list[str]:
    """Say what a fit makes of all that is stated beforehand, a line for each."""
    return [
        f"{one.name} = {_with_unit(one.found)} (fitted beside it, stated {_with_unit(one.stated)})"
        for one in nuisances
    ]


def _with_unit(quantity: Quantity) -> str:
    return quantity.concise() + ("" if quantity.unit == "1" else f" {quantity.unit}")
