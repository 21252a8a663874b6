"""A computation over effects that goes on without those that fail in it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from typing import TypeVar

from analysis.effects.effect import Effect
from analysis.effects.own.fault import EffectFault, Fault

Result = TypeVar("Result")


def without_faulty(
    effects: Sequence[Effect], compute: Callable[[Sequence[Effect]], Result]
) -> tuple[Result, tuple[Fault, ...]]:
    """Compute with all effects; where one fails, again without it.

    The result is that of the effects that are left, as if no other had been handed in. What the
    effects print goes to standard error.

    Raises
    ------
    EffectFault
        An effect fails that is not one of these, so that leaving it out is not for this function.
    """
    left, faults = tuple(effects), list[Fault]()
    while True:
        try:
            with redirect_stdout(sys.stderr):
                return compute(left), tuple(faults)
        except EffectFault as error:
            fewer = tuple(effect for effect in left if effect.name != error.fault.effect)
            if len(fewer) == len(left):
                raise
            left = fewer
            faults.append(error.fault)
