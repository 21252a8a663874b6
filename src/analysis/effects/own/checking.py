"""An effect tried before it is used: what it declares, and how it behaves on a few shots."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

from analysis.effects.effect import Effect
from analysis.effects.own import behaviour, declaration
from analysis.effects.own.fault import EffectFault, Fault
from analysis.effects.own.guard import function_line, function_of, guarded

PURE = frozenset({0.0, 0.5, 1.0, 2.0, 3.0, 4.0})
"""Decimals within a formula that are taken to have no unit; whole numbers are taken so too."""
UNITLESS = ("numpy", "math", "dataclasses", "analysis.collision", "analysis.effects.effect")
"""Modules whose functions and types bring no number with a unit into a formula."""


def has_own_numbers(function: Callable[..., Any]) -> bool:
    """Whether a function, or one of its file that it calls, uses a number that may have a unit.

    Such are constants of its file, values that a closure holds or that arguments have by default,
    decimals within a formula, and whatever comes from a module that is not known to be without.
    """
    return not isinstance(function, FunctionType) or _searched(function, set())


def _searched(function: FunctionType, seen: set[CodeType]) -> bool:
    if function.__code__ in seen:
        return False
    seen.add(function.__code__)
    if function.__closure__ or function.__defaults__ or function.__kwdefaults__:
        return True
    known = function.__globals__
    for code in _nested(function.__code__):
        if any(isinstance(c, float) and abs(c) not in PURE for c in code.co_consts):
            return True
        used = [known[name] for name in code.co_names if name in known]
        if any(_may_carry(thing, function, seen) for thing in used):
            return True
    return False


def _may_carry(thing: object, function: FunctionType, seen: set[CodeType]) -> bool:
    if isinstance(thing, FunctionType) and thing.__globals__ is function.__globals__:
        return _searched(thing, seen)
    if isinstance(thing, ModuleType):
        return not _unitless(thing.__name__)
    return not (callable(thing) and _unitless(str(getattr(thing, "__module__", ""))))


def _unitless(module: str) -> bool:
    return any(module == name or module.startswith(f"{name}.") for name in UNITLESS)


def _nested(code: CodeType) -> Iterator[CodeType]:
    yield code
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from _nested(inner)


def checked(effect: Effect, path: Path, line: int) -> Effect:
    """Return an effect that can be fitted and ranked, under watch.

    Parameters
    ----------
    path, line
        Where it is defined.

    Raises
    ------
    EffectFault
        It cannot; the first reason found. What it declares is named at its definition, what it
        does at its function.
    """
    if found := declaration.first_fault(effect):
        raise EffectFault(Fault(path, line, str(effect.name), *found))
    watched = guarded(effect, path, line)
    for mine, tried in zip((effect, *effect.variants), (watched, *watched.variants), strict=True):
        function = function_of(mine)
        found = behaviour.first_fault(tried, has_own_numbers=has_own_numbers(function))
        if found:
            place = function_line(path, function) or line
            raise EffectFault(Fault(path, place, effect.name, *found))
    return watched
