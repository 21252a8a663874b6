"""An effect tried before it is used: what it declares, and how it behaves on a few shots."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

from analysis.effects.effect import Effect, Parameter
from analysis.effects.own import behaviour, units
from analysis.effects.own.fault import EffectFault, Fault
from analysis.effects.own.guard import FUNCTIONS, function_line, function_of, guarded
from analysis.effects.own.template import FORM, well_formed

TEXTS = ("title", "formula", "source", "gives_away")


def first_fault(effect: Effect) -> tuple[str, str] | None:
    """Return the first fault and its remedy, None without one.

    A file may hold values of any type in any field.
    """
    name: object = effect.name
    if not isinstance(name, str) or not well_formed(name):
        return f"its name {name!r} is not in the form of names", f"use {FORM}"
    stage = getattr(effect, "stage", None)
    if stage not in FUNCTIONS:
        return f"its stage is {stage}", f"choose a class of effects of {', '.join(FUNCTIONS)}"
    if not callable(function_of(effect)):
        return f"its {FUNCTIONS[stage]} is no function", f"give {FUNCTIONS[stage]} a function"
    for field in TEXTS:
        text: object = getattr(effect, field)
        if not isinstance(text, str) or not text.strip():
            return f"says nothing as its {field}", f"write one sentence as {field}"
    names: object = effect.confused_with
    if not isinstance(names, tuple) or not all(isinstance(name, str) for name in names):
        return "is confused with what are no names", "give confused_with as a tuple of names"
    return _of_parameters(effect) or _of_variants(effect)


def _of_parameters(effect: Effect) -> tuple[str, str] | None:
    parameters: object = effect.parameters
    if not isinstance(parameters, tuple) or not parameters:
        return "has no parameters", "give it a tuple of at least one Parameter"
    for parameter in parameters:
        if not isinstance(parameter, Parameter):
            return f"has {parameter!r} among its parameters", "use Parameter(...)"
        if found := _of_parameter(parameter):
            return f"parameter {parameter.symbol}: {found[0]}", found[1]
    symbols = [parameter.symbol for parameter in parameters]
    if len(set(symbols)) < len(symbols):
        return f"two of its parameters share a symbol ({', '.join(symbols)})", "rename one"
    return None


def _of_parameter(parameter: Parameter) -> tuple[str, str] | None:
    for field in ("symbol", "unit", "meaning"):
        text: object = getattr(parameter, field)
        if not isinstance(text, str) or not text.strip():
            return f"says nothing as its {field}", f"write its {field} as text"
    try:
        units.Dimension.of(parameter.unit)
    except ValueError as error:
        return f"its unit {parameter.unit!r} is not known: {error}", f"use {units.FORM}"
    return _of_numbers(parameter)


def _of_numbers(parameter: Parameter) -> tuple[str, str] | None:
    plausible: object = parameter.plausible
    if not isinstance(plausible, tuple) or len(plausible) != 2:
        return f"its plausible range is {plausible!r}", "give the two ends, (low, high)"
    numbers = (*plausible, parameter.off, parameter.step)
    if not all(isinstance(n, int | float) and math.isfinite(n) for n in numbers):
        return "its range, off value or step is no finite number", "give finite numbers"
    low, high, off, step = numbers
    if not low < high:
        return f"its plausible range {low:g} to {high:g} is empty", "put the lower end first"
    if not low <= off <= high:
        return f"its off value {off:g} is not in {low:g} to {high:g}", "widen the plausible range"
    if step <= 0 or (parameter.one_sided and off != low):
        what = (
            f"its step is {step:g}"
            if step <= 0
            else f"is one-sided and off within {low:g} to {high:g}"
        )
        return what, "give a step above 0, and let a one-sided range begin at off"
    return None


def _of_variants(effect: Effect) -> tuple[str, str] | None:
    variants: object = effect.variants
    if not isinstance(variants, tuple) or not all(isinstance(v, Effect) for v in variants):
        return "has variants that are no effects", "give variants as a tuple of effects"
    for variant in effect.variants:
        if type(variant) is not type(effect) or variant.name != effect.name:
            return "has a variant that is another effect", "give variants its name and stage"
        if [p.symbol for p in variant.parameters] != [p.symbol for p in effect.parameters]:
            return "has a variant with other parameters", "give variants the same parameters"
        if found := first_fault(variant):
            return f"variant {variant.title!r}: {found[0]}", found[1]
    return None


PURE = frozenset({0.0, 0.5, 1.0, 2.0, 3.0, 4.0})
"""Decimals within a formula that are taken to have no unit; whole numbers are taken so too."""
UNITLESS = ("numpy", "math", "dataclasses", "analysis.collision", "analysis.effects.effect")
"""Modules whose functions and types bring no number with a unit into a formula."""


def has_literal_numbers(function: Callable[..., Any]) -> bool:
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
    if found := first_fault(effect):
        raise EffectFault(Fault(path, line, str(effect.name), *found))
    watched = guarded(effect, path, line)
    for mine, tried in zip((effect, *effect.variants), (watched, *watched.variants), strict=True):
        function = function_of(mine)
        found = behaviour.first_fault(tried, has_literal_numbers=has_literal_numbers(function))
        if found:
            place = function_line(path, function) or line
            raise EffectFault(Fault(path, place, effect.name, *found))
    return watched
