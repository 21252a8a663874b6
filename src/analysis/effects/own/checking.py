"""An effect tried before it is used: what it declares, and how it behaves on a few shots."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import Effect, Parameter
from analysis.effects.own import units
from analysis.effects.own.fault import EffectFault, Fault
from analysis.effects.own.guard import FUNCTIONS, function_line, function_of, guarded
from analysis.effects.own.rehearsal import SI, AnyColumn, Units, response, unchanged
from analysis.effects.own.template import FORM, well_formed
from analysis.effects.own.units import Dimension

Complaint = tuple[str, str]

ROUNDING = 1e-11
"""Of a response in usual sizes; what is off may change so much and no more."""
LEAST_INFLUENCE = 1e-7
"""Of a response in usual sizes: 0.1 micrometre a second, 0.1 nanosecond, a nanometre."""
LEAST_SLOPE = 1e-3
"""Of the slope where an effect is off, as a share of that over the plausible range."""
SAME_SLOPE = 0.05
"""By which the slopes by a whole and by half a step may differ."""
FACTOR = 2.0
SAME_POWER, CONSTANT = 0.05, 0.01
OTHER_VALUES = ((0.0, 2.0), (50.0, 100.0), (500.0, 1000.0))
"""Middles and widths of columns: a threshold in pressure is not reached by a temperature."""


def first_misbehaviour(effect: Effect, *, has_literal_numbers: bool) -> Complaint | None:
    """Return what is wrong first of a function on a few shots, and what to do; None: nothing.

    Fit and ranking start from the first derivative where the effect is off; an effect without one
    would pass for one that these shots cannot show.

    Parameters
    ----------
    has_literal_numbers
        The function uses numbers that may have a unit; then its parameter's unit is not checked.

    Raises
    ------
    EffectFault
        An effect under watch fails.
    """
    columns = AnyColumn()
    off = response(effect, effect.off, SI, columns)
    if float(np.abs(off - unchanged(effect)).max()) > ROUNDING:
        values = ", ".join(f"{p.symbol} = {p.off:g}" for p in effect.parameters)
        return f"changes something where it is off ({values})", "see that it then changes nothing"
    if found := _by_itself(effect):
        return found
    for k, parameter in enumerate(effect.parameters):
        found = _influence(effect, k, off, columns)
        if found is not None and _is_seen_elsewhere(effect, k, columns):
            found = None
        if (
            found is None
            and not has_literal_numbers
            and not columns.names_read
            and parameter.off == 0
        ):
            found = _unit(effect, k)
        if found:
            return f"parameter {parameter.symbol} {found[0]}", found[1]
    return None


def _by_itself(effect: Effect) -> Complaint | None:
    """See that the same shots give the same, and each shot the same in whatever company."""
    values = np.array([p.off + (_far(p) - p.off) / 2 for p in effect.parameters])
    first, again = (response(effect, values, SI, AnyColumn()) for _ in range(2))
    if float(np.abs(first - again).max()) > ROUNDING:
        return "gives another answer when it is asked again", "take chance and memory out of it"
    some = slice(1, None, 3)
    apart = response(effect, values, SI, AnyColumn(some))
    if float(np.abs(first[some] - apart).max()) > ROUNDING:
        return (
            "lets what one shot does depend on the others",
            "use no mean, count or place in the row: fit and ranking ask for shots many times over",
        )
    return None


def _is_seen_elsewhere(effect: Effect, k: int, columns: AnyColumn) -> bool:
    """Whether a parameter acts at other values of the columns that the function reads."""
    if not columns.names_read:
        return False
    for middle, width in OTHER_VALUES:
        there = AnyColumn(middle=middle, width=width)
        if _influence(effect, k, response(effect, effect.off, SI, there), there) is None:
            return True
    return False


def _far(parameter: Parameter) -> float:
    """Return the end of the plausible range that is further from off."""
    return max(parameter.plausible, key=lambda end: abs(end - parameter.off))


def _influence(effect: Effect, k: int, off: Floats, columns: AnyColumn) -> Complaint | None:
    """See that a parameter changes something over its range, and evenly where it is off."""
    parameter = effect.parameters[k]

    def change(value: float) -> Floats:
        values = effect.off
        values[k] = value
        return response(effect, values, SI, columns) - off

    ends = [end for end in parameter.plausible if end != parameter.off]
    changes = {end: change(end) for end in ends}
    far = max(ends, key=lambda end: float(np.abs(changes[end]).max()))
    if float(np.abs(changes[far]).max()) < LEAST_INFLUENCE:
        return (
            f"changes nothing up to {_shown(parameter, far)}",
            "use values in the function, or widen the plausible range",
        )
    whole = change(parameter.off + parameter.step) / parameter.step
    half = change(parameter.off + parameter.step / 2) / (parameter.step / 2)
    slope = float(np.abs(whole).max())
    if slope < LEAST_SLOPE * float(np.abs(changes[far] / (far - parameter.off)).max()):
        return (
            "has no influence to first order where it is off, where ranking looks for it",
            "let what it changes begin in proportion to it, for instance by fitting its square",
        )
    if float(np.abs(whole - half).max()) > SAME_SLOPE * slope:
        return (
            f"has no slope where it is off: it changes with the step {parameter.step:g}",
            "choose another step, or a form that begins in proportion to the parameter",
        )
    return None


def _unit(effect: Effect, k: int) -> Complaint | None:
    """Hold the declared unit against the one that the function makes of the parameter.

    The shots are written in other units of length, time and mass in turn. Where the response to
    the same number then differs by one factor throughout, that factor is the parameter's own.
    """
    parameter = effect.parameters[k]
    here = _slope(effect, k, SI)
    powers = []
    for other in (Units(length=FACTOR), Units(time=FACTOR), Units(mass=FACTOR)):
        there = _slope(effect, k, other)
        large = np.abs(here) > 1e-3 * np.abs(here).max()
        if not np.all(there[large] / here[large] > 0):
            return None
        power = -np.log(there[large] / here[large]) / np.log(FACTOR)
        if np.ptp(power) > CONSTANT:
            return None
        powers.append(float(power.mean()))
    found = np.array([*powers, 0.0])
    declared = np.array(Dimension.of(parameter.unit).exponents)
    if float(np.abs(found - declared).max()) < SAME_POWER:
        return None
    length, time, mass, _ = (round(power, 2) + 0.0 for power in found)
    return (
        f"is declared in {parameter.unit}, but the function takes it in "
        f"{Dimension((length, time, mass, 0.0))}",
        "mend the formula or the unit; a number that has a unit stands as a constant of the file",
    )


def _slope(effect: Effect, k: int, units: Units) -> Floats:
    columns, values = AnyColumn(), effect.off
    base = response(effect, values, units, columns)
    values[k] += effect.parameters[k].step
    return (response(effect, values, units, columns) - base) / effect.parameters[k].step


def _shown(parameter: Parameter, value: float) -> str:
    return f"{value:g}" + ("" if parameter.unit == "1" else f" {parameter.unit}")


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
        found = first_misbehaviour(tried, has_literal_numbers=has_literal_numbers(function))
        if found:
            place = function_line(path, function) or line
            raise EffectFault(Fault(path, place, effect.name, *found))
    return watched
