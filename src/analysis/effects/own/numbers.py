"""Whether a function uses numbers of its own that may carry a unit."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from numbers import Number
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

PURE = frozenset({0.0, 0.5, 1.0, 2.0, 3.0, 4.0})
"""Numbers written within a formula that are taken to have no unit."""
UNITLESS_MODULES = frozenset({"numpy", "math"})


def has_own_numbers(function: Callable[..., Any]) -> bool:
    """Whether a function, or one of its file that it calls, uses a number that may have a unit.

    Such are constants of its file, values that a closure holds, whatever comes from a module other
    than NumPy and math, and numbers within a formula that are not small and whole.
    """
    if not isinstance(function, FunctionType):
        return True
    return _searched(function, set())


def _searched(function: FunctionType, seen: set[CodeType]) -> bool:
    if function.__code__ in seen:
        return False
    seen.add(function.__code__)
    held = [cell.cell_contents for cell in function.__closure__ or ()]
    defaults = list(function.__defaults__ or ())
    for code in _nested(function.__code__):
        if any(isinstance(c, float) and abs(c) not in PURE for c in code.co_consts):
            return True
        held.extend(_globals(code, function.__globals__))
    return any(_carries(thing, function, seen) for thing in [*held, *defaults])


def _carries(thing: object, function: FunctionType, seen: set[CodeType]) -> bool:
    if isinstance(thing, Number | np.ndarray):
        return True
    if isinstance(thing, ModuleType):
        return thing.__name__ not in UNITLESS_MODULES
    if isinstance(thing, FunctionType) and thing.__globals__ is function.__globals__:
        return _searched(thing, seen)
    return False


def _nested(code: CodeType) -> Iterator[CodeType]:
    yield code
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from _nested(inner)


def _globals(code: CodeType, known: Mapping[str, object]) -> list[object]:
    return [known[name] for name in code.co_names if name in known]
