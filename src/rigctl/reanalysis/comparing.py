"""Two results of the same shots, side by side."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rigctl.reanalysis.campaign import Outcome

Json = Mapping[str, Any]

QUANTITIES = ("v_n", "v_s", "v_n_after", "v_s_after", "e", "beta")


@dataclass(frozen=True, slots=True)
class Comparison:
    """How one quantity changed over the shots that both results measure.

    Attributes
    ----------
    shots
        How many.
    mean, rms
        Of the differences, later minus earlier, in `unit`.
    rms_sigmas
        Root mean square of the differences, each in units of its own standard error, the two
        taken as independent: they see the same frames, so that less than 1 is to be expected.
    """

    quantity: str
    unit: str
    shots: int
    mean: float
    rms: float
    rms_sigmas: float | None


def compared(outcomes: Sequence[Outcome]) -> list[Comparison]:
    """Compare the results before with those that were added, quantity by quantity."""
    pairs = [(o.before, o.after) for o in outcomes if o.before is not None and o.after is not None]
    found = (_one(quantity, pairs) for quantity in QUANTITIES)
    return [comparison for comparison in found if comparison is not None]


def _one(quantity: str, pairs: Sequence[tuple[Json, Json]]) -> Comparison | None:
    both = [
        (first, second)
        for before, after in pairs
        if (first := before.get(quantity)) is not None
        and (second := after.get(quantity)) is not None
    ]
    if not both:
        return None
    differences = [second["value"] - first["value"] for first, second in both]
    variances = [first["sigma"] ** 2 + second["sigma"] ** 2 for first, second in both]
    stated = [(d, v) for d, v in zip(differences, variances, strict=True) if 0 < v < math.inf]
    return Comparison(
        quantity,
        str(both[0][1]["unit"]),
        len(both),
        mean=sum(differences) / len(both),
        rms=_rms(differences),
        rms_sigmas=_rms([d / math.sqrt(v) for d, v in stated]) if stated else None,
    )


def _rms(values: Sequence[float]) -> float:
    return math.sqrt(sum(value * value for value in values) / len(values))
