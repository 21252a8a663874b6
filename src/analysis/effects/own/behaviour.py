"""Checks of an effect's function on a few shots: no change where it is off, a change where on.

Fit and ranking start from the first derivative where the effect is off; an effect without one
would pass for one that these shots cannot show.
"""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import Effect, Parameter
from analysis.effects.own.rehearsal import SI, AnyColumn, Units, response, unchanged
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


def first_fault(effect: Effect, *, has_literal_numbers: bool) -> Complaint | None:
    """Return the first thing that is wrong and what to do about it; None: all is well.

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
    for units in (Units(length=FACTOR), Units(time=FACTOR), Units(mass=FACTOR)):
        there = _slope(effect, k, units)
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
