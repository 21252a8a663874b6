"""Which arguments vary enough in a campaign to be tested, and why the others do not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from types import MappingProxyType

import numpy as np

from analysis.arrays import Floats
from analysis.collision.operator import Encounter
from analysis.model.proposals.arguments import (
    OF_PLACES,
    SPEEDS,
    Argument,
    is_column,
    known_arguments,
)
from analysis.model.verdict.forward import ranks_of

FEWEST_SHOTS = 12
"""Of fewer shots a handful of forms fits any residual."""
LEAST_SIGMAS = 3.0
"""An amplitude nearer to zero than so many of its errors is not determined."""
LEAST_RANGE = 1e-9
COPY, CONFOUNDED = 0.99999, 0.97
"""Correlations of ranks from which two arguments are one and the same, or nearly."""
NUMBERS_PLEASE = "write a number into each of its fields"
NOTHING: Mapping[str, str] = MappingProxyType({})
LEAST_PLACES = 3
"""Different values without which an argument has no shape."""


@dataclass(frozen=True, slots=True)
class LeftOut:
    """An argument that takes no part: why, and which shots would bring it in.

    `copy_of` names the argument that it is one and the same as in these shots, if it is.
    """

    argument: str
    reason: str
    todo: str
    copy_of: str = ""


@dataclass(frozen=True, slots=True)
class Confounded:
    """Two arguments that run together through the campaign; `todo` are shots that part them."""

    arguments: tuple[str, str]
    correlation: float
    todo: str


@dataclass(frozen=True, slots=True, eq=False)
class Admitted:
    """The arguments that take part, those that do not, and those that run together."""

    arguments: tuple[Argument, ...]
    left_out: tuple[LeftOut, ...]
    confounded: tuple[Confounded, ...]

    def copies(self, argument: str) -> list[str]:
        """Return what an argument, or a product of two, may be called as well in these shots."""
        parts = argument.split("*")
        found = []
        for one in self.left_out:
            if one.copy_of in parts:
                named = [one.argument if part == one.copy_of else part for part in parts]
                found.append("*".join(sorted(named)))
        return found


def admitted(
    encounter: Encounter,
    *,
    scalars: bool,
    one_frame: bool,
    unused: Mapping[str, str] = NOTHING,
) -> Admitted:
    """Sort out the arguments of a campaign's encounters.

    Parameters
    ----------
    unused
        Columns of the shot list that are none, with the reason.
    """
    offered = known_arguments(encounter, scalars=scalars, one_frame=one_frame)
    kept = list[Argument]()
    left_out = [LeftOut(name, reason, NUMBERS_PLEASE) for name, reason in unused.items()]
    for argument in offered:
        values = argument.of(encounter)
        found = _without_range(argument, values) or _copy(argument, values, kept, encounter)
        if found is None:
            kept.append(argument)
        else:
            left_out.append(found)
    return Admitted(tuple(kept), tuple(left_out), tuple(_confounded(kept, encounter)))


def _without_range(argument: Argument, values: Floats) -> LeftOut | None:
    different = len(np.unique(values.round(12), axis=0))
    widest = float(np.ptp(values, axis=0).max())
    size = max(float(np.abs(values).max()), 1.0)
    # A column has its unit in its name, and differences of degrees are in K.
    unit = "" if argument.unit == "1" or is_column(argument) else f" {argument.unit}"
    if not np.isfinite(values).all():
        return LeftOut(argument.name, "not a number in every shot", "fill in the missing fields")
    if widest < LEAST_RANGE * size:
        value = float(values[0, 0])
        return LeftOut(
            argument.name,
            f"the same in all shots, {value:.6g}{unit}",
            f"fire shots at {LEAST_PLACES} or more values of {argument.name}",
        )
    if different < LEAST_PLACES:
        return LeftOut(
            argument.name,
            f"has {different} values only, which any other change between them would explain",
            f"fire shots at {LEAST_PLACES} or more values of {argument.name}",
        )
    return None


def _copy(
    argument: Argument, values: Floats, kept: Sequence[Argument], encounter: Encounter
) -> LeftOut | None:
    """Tell of what an argument is a copy, or the same in other units."""
    if not argument.is_scalar:
        return None
    for other in kept:
        if other.is_scalar and other.name != argument.name:
            both = _line(values[:, 0]), _line(other.of(encounter)[:, 0])
            if abs(float((both[0] * both[1]).mean())) > COPY:
                return LeftOut(
                    argument.name,
                    f"one and the same as {other.name} in all shots",
                    f"fire shots in which {argument.name} changes and {other.name} does not",
                    other.name,
                )
    return None


def _confounded(kept: Sequence[Argument], encounter: Encounter) -> list[Confounded]:
    scalar = [a for a in kept if a.is_scalar and a.symbol != "|w_n|"]
    ranks = {a.key: _line(ranks_of(a.of(encounter)[:, 0])) for a in scalar}
    found = []
    for a, b in combinations(scalar, 2):
        both = float((ranks[a.key] * ranks[b.key]).mean())
        if abs(both) > CONFOUNDED:
            hold, vary = (a, b) if _is_result(a) else (b, a)
            found.append(
                Confounded(
                    (a.name, b.name),
                    both,
                    f"fire shots in which {vary.name} changes and {hold.name} does not",
                )
            )
    return found


def _is_result(argument: Argument) -> bool:
    """Whether nobody sets it: it comes of how the spheres meet."""
    return any(argument is other for other in (*SPEEDS, *OF_PLACES))


def _line(values: Floats) -> Floats:
    centred = values - values.mean()
    return np.asarray(centred / max(float(centred.std()), 1e-300))
