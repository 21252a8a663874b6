"""A user's effect under watch: whatever goes wrong in it is named with its file and line.

The function of the effect is wrapped. What it is given is read-only; what it raises, and what it
returns in a wrong form, becomes an `EffectFault`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from types import CodeType
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from analysis.collision.operator import Encounter, Operator, Outcome
from analysis.effects.effect import (
    CameraEffect,
    ClockEffect,
    ContactEffect,
    Effect,
    Exposure,
    FlightEffect,
    Floats,
    Flying,
    Values,
)
from analysis.effects.own.fault import EffectFault, Fault, line_in, said
from analysis.setup import CameraSetup

Result = TypeVar("Result")
Given = TypeVar("Given")

FUNCTIONS = {"contact": "wrap", "flight": "accelerate", "camera": "appear", "clock": "expose"}
"""The function that acts, by the stage it acts in."""


@dataclass(frozen=True, slots=True)
class Watch:
    """Where an effect stands and the range it is believed in, for what is said of its faults."""

    path: Path
    line: int
    effect: Effect

    def fault(self, what: str, todo: str, line: int | None = None) -> EffectFault:
        """Return a fault of this effect, at its function where no line is known."""
        return EffectFault(Fault(self.path, line or self.line, self.effect.name, what, todo))

    def call(self, function: Callable[..., Result], *arguments: object) -> Result:
        """Call a function of the user's file.

        Raises
        ------
        EffectFault
            It raised anything; or an effect within it did, and that one is named.
        """
        try:
            # What is not finite is judged by the result, where it can be named.
            with np.errstate(all="ignore"):
                return function(*arguments)
        except EffectFault:
            raise
        except Exception as error:
            line = line_in(self.path, error.__traceback__)
            raise self.fault(f"raised {said(error)}", "mend the function", line) from error

    def array(self, name: str, found: object, shape: tuple[int, ...], values: Values) -> Floats:
        """Return what a function gave, if it is an array of this shape and finite where believed.

        Beyond the plausible range a fit only tries whether it may go there; there an effect may
        say by NaN that it may not.

        Raises
        ------
        EffectFault
            It is no array of real numbers, has another shape, or is not finite.
        """
        if not isinstance(found, np.ndarray) or found.dtype.kind not in "fiu":
            kind = f"an array of {found.dtype}" if isinstance(found, np.ndarray) else _a(found)
            raise self.fault(f"returned {kind} for {name}", "return a NumPy array of real numbers")
        if found.shape != shape:
            raise self.fault(
                f"returned {name} of shape {found.shape}", f"return an array of shape {shape}"
            )
        if self._believed(values) and not np.isfinite(found).all():
            raise self.fault(
                f"returned {name} that is not finite at {self._at(values)}",
                "see to it that the function has a value in all of the plausible range",
            )
        return cast("Floats", found)

    def _believed(self, values: Values) -> bool:
        return all(
            p.plausible[0] <= value <= max(p.plausible[1], p.off + p.step)
            for p, value in zip(self.effect.parameters, values, strict=True)
        )

    def _at(self, values: Values) -> str:
        return ", ".join(
            f"{p.symbol} = {value:g}" + ("" if p.unit == "1" else f" {p.unit}")
            for p, value in zip(self.effect.parameters, values, strict=True)
        )


def function_of(effect: Effect) -> Callable[..., Any]:
    """Return the function of an effect that acts."""
    return cast("Callable[..., Any]", getattr(effect, FUNCTIONS[effect.stage]))


def function_line(path: Path, function: object) -> int | None:
    """Return the line where a function begins; None: it is not written in this file."""
    code = getattr(function, "__code__", None)
    if isinstance(code, CodeType) and code.co_filename == str(path):
        return code.co_firstlineno
    return None


def guarded(effect: Effect, path: Path, line: int) -> Effect:
    """Return the effect with its function, and those of its variants, under watch.

    Parameters
    ----------
    line
        What is named for an effect whose function is not written in the file.
    """
    watch = Watch(path, function_line(path, function_of(effect)) or line, effect)
    variants = tuple(guarded(variant, path, line) for variant in effect.variants)
    if isinstance(effect, ContactEffect):
        return replace(effect, variants=variants, wrap=_contact(effect, watch))
    if isinstance(effect, FlightEffect):
        return replace(effect, variants=variants, accelerate=_flight(effect, watch))
    if isinstance(effect, CameraEffect):
        return replace(effect, variants=variants, appear=_camera(effect, watch))
    if isinstance(effect, ClockEffect):
        return replace(effect, variants=variants, expose=_clock(effect, watch))
    raise TypeError(f"{effect.name} acts in no stage")


def _contact(effect: ContactEffect, watch: Watch) -> Callable[[Operator, Values], Operator]:
    def wrap(operator: Operator, values: Values) -> Operator:
        changed = watch.call(effect.wrap, operator, _read_only(values))
        if not callable(changed):
            raise watch.fault(
                f"returned {_a(changed)}, not an operator", "return a function of an encounter"
            )

        def watched(encounter: Encounter) -> Outcome:
            outcome = watch.call(changed, _read_only(encounter))
            if not isinstance(outcome, Outcome):
                raise watch.fault(
                    f"its operator returned {_a(outcome)}", "return the outcome of an operator"
                )
            _see_outcome(watch, outcome, encounter.normal.shape, values)
            return outcome

        return watched

    return wrap


def _see_outcome(watch: Watch, outcome: Outcome, shape: tuple[int, ...], values: Values) -> None:
    for name in ("velocity_a", "velocity_b", "spin_a", "spin_b"):
        watch.array(f"after.{name}", getattr(outcome.after, name), shape, values)
    for name in ("shift_a", "shift_b", "turn_a", "turn_b"):
        watch.array(name, getattr(outcome, name), shape, values)
    watch.array("duration", outcome.duration, shape[:1], values)


def _flight(
    effect: FlightEffect, watch: Watch
) -> Callable[[Flying, Values], tuple[Floats, Floats]]:
    def accelerate(flying: Flying, values: Values) -> tuple[Floats, Floats]:
        found = watch.call(effect.accelerate, _read_only(flying), _read_only(values))
        linear, angular = _pair(watch, found, "acceleration and angular acceleration")
        shape = flying.velocity.shape
        return (
            watch.array("acceleration", linear, shape, values),
            watch.array("angular acceleration", angular, shape, values),
        )

    return accelerate


def _camera(effect: CameraEffect, watch: Watch) -> Callable[[Floats, CameraSetup, Values], Floats]:
    def appear(position: Floats, camera: CameraSetup, values: Values) -> Floats:
        found = watch.call(effect.appear, _read_only(position), camera, _read_only(values))
        return watch.array("position", found, position.shape, values)

    return appear


def _clock(
    effect: ClockEffect, watch: Watch
) -> Callable[[Exposure, CameraSetup, Values], tuple[Floats, Floats]]:
    def expose(exposure: Exposure, camera: CameraSetup, values: Values) -> tuple[Floats, Floats]:
        found = watch.call(effect.expose, _read_only(exposure), camera, _read_only(values))
        position, rotation = _pair(watch, found, "times of position and of orientation")
        shape = exposure.position.shape
        return (
            watch.array("times of position", _spread(position, shape), shape, values),
            watch.array("times of orientation", _spread(rotation, shape[:-1]), shape[:-1], values),
        )

    return expose


def _pair(watch: Watch, found: object, names: str) -> tuple[object, object]:
    if not isinstance(found, tuple) or len(found) != 2:
        raise watch.fault(f"returned {_a(found)}", f"return two arrays, {names}")
    return found[0], found[1]


def _spread(found: object, shape: tuple[int, ...]) -> object:
    """Return an array spread to a shape that its own broadcasts to; anything else as it is."""
    if not isinstance(found, np.ndarray):
        return found
    try:
        return np.broadcast_to(found, shape)
    except ValueError:
        return found


def _read_only(given: Given) -> Given:
    """Return what a function is given with arrays, at any depth, that cannot be written to."""
    if isinstance(given, np.ndarray):
        view: NDArray[Any] = given.view()
        view.flags.writeable = False
        return cast("Given", view)
    if isinstance(given, dict):
        return cast("Given", {name: _read_only(part) for name, part in given.items()})
    if not is_dataclass(given) or isinstance(given, type):
        return given
    parts = {field.name: getattr(given, field.name) for field in fields(given)}
    return replace(given, **{name: _read_only(part) for name, part in parts.items()})


def _a(found: object) -> str:
    return "nothing" if found is None else f"a value of type {type(found).__name__}"
