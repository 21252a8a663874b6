"""A user's effect under watch: whatever goes wrong in it is named with its file and line.

The function of the effect is wrapped: its arguments are read-only, and its exceptions and results
of a wrong form become an `EffectFault`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from types import CodeType
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.operator import Encounter, Operator, Outcome, States
from analysis.effects.effect import (
    CameraEffect,
    ClockEffect,
    ContactEffect,
    Effect,
    Exposure,
    FlightEffect,
    Flying,
    Values,
)
from analysis.effects.own.fault import EffectFault, Fault, exception_text, line_in
from analysis.setup import CameraSetup

Result = TypeVar("Result")
Thing = TypeVar("Thing")


@dataclass(frozen=True, slots=True, eq=False)
class Given:
    """Arguments of a call.

    Attributes
    ----------
    values
        Values of the parameters.
    sound
        Returns whether all other input was finite; called only when the result is not.
    """

    values: Values
    sound: Callable[[], bool]


@dataclass(frozen=True, slots=True)
class Watch:
    """File, line and effect, to name in faults of its function."""

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
            # Values that are not finite are found in the result, where they can be named.
            with np.errstate(all="ignore"):
                return function(*arguments)
        except EffectFault:
            raise
        except (Exception, SystemExit) as error:
            line = line_in(self.path, error.__traceback__)
            raise self.fault(
                f"raised {exception_text(error)}", "mend the function", line
            ) from error

    def array(self, name: str, found: object, shape: tuple[int, ...], given: Given) -> Floats:
        """Return the checked result of a function: an array of this shape, finite where required.

        Beyond the plausible range an effect may return NaN, which a fit takes as a bound. NaN in
        the input may give NaN as well.

        Raises
        ------
        EffectFault
            It is no array of real numbers, has another shape, or is not finite.
        """
        if not isinstance(found, np.ndarray) or found.dtype.kind not in "fiu":
            kind = f"an array of {found.dtype}" if isinstance(found, np.ndarray) else a_value(found)
            raise self.fault(f"returned {kind} for {name}", "return a NumPy array of real numbers")
        if found.shape != shape:
            raise self.fault(
                f"returned {name} of shape {found.shape}", f"return an array of shape {shape}"
            )
        if not np.isfinite(found).all() and self._plausible(given.values) and given.sound():
            raise self.fault(
                f"returned {name} that is not finite at {self._at(given.values)}",
                "see to it that the function has a value in all of the plausible range",
            )
        return found.astype(np.float64, copy=False)

    def _plausible(self, values: Values) -> bool:
        return all(
            p.plausible[0] <= value <= max(p.plausible[1], p.off + p.step)
            for p, value in zip(self.effect.parameters, values, strict=True)
        )

    def _at(self, values: Values) -> str:
        return ", ".join(
            f"{p.symbol} = {value:g}" + ("" if p.unit == "1" else f" {p.unit}")
            for p, value in zip(self.effect.parameters, values, strict=True)
        )


class _Columns(dict[str, Floats]):
    """Columns of the shot list; one that is not there is named beside those that are."""

    def __missing__(self, name: str) -> Floats:
        raise KeyError(f"not every shot has a column {name}; all have {', '.join(sorted(self))}")


def read_only(thing: Thing) -> Thing:
    """Return an argument with read-only arrays at any depth."""
    if isinstance(thing, np.ndarray):
        view: NDArray[Any] = thing.view()
        view.flags.writeable = False
        return cast("Thing", view)
    if isinstance(thing, dict):
        return cast("Thing", _Columns({name: read_only(part) for name, part in thing.items()}))
    if not is_dataclass(thing) or isinstance(thing, type):
        return thing
    return replace(thing, **{name: read_only(part) for name, part in _parts(thing).items()})


def finite(thing: object) -> bool:
    """Whether every number of an argument, at any depth, is finite."""
    if isinstance(thing, np.ndarray):
        return thing.dtype.kind != "f" or bool(np.isfinite(thing).all())
    if is_dataclass(thing):
        return all(finite(part) for part in _parts(thing).values())
    return True


def _parts(thing: object) -> dict[str, Any]:
    return {field.name: getattr(thing, field.name) for field in fields(cast("Any", thing))}


def a_value(found: object) -> str:
    """Return the type of a value in words."""
    return "nothing" if found is None else f"a value of type {type(found).__name__}"


FUNCTIONS = {"contact": "wrap", "flight": "accelerate", "camera": "appear", "clock": "expose"}
"""Name of the function of an effect, by its stage."""


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
        changed = watch.call(effect.wrap, operator, read_only(values))
        if not callable(changed):
            raise watch.fault(
                f"returned {a_value(changed)}, not an operator", "return a function of an encounter"
            )

        def watched(encounter: Encounter) -> Outcome:
            outcome = watch.call(changed, read_only(encounter))
            if not isinstance(outcome, Outcome) or not isinstance(outcome.after, States):
                raise watch.fault(
                    f"its operator returned {a_value(outcome)}", "return the outcome of an operator"
                )

            def sound() -> bool:
                return finite(encounter) and finite(operator(encounter))

            return _seen(watch, outcome, encounter.normal.shape, Given(values, sound))

        return watched

    return wrap


def _seen(watch: Watch, outcome: Outcome, shape: tuple[int, ...], given: Given) -> Outcome:
    after = {
        name: watch.array(f"after.{name}", getattr(outcome.after, name), shape, given)
        for name in ("velocity_a", "velocity_b", "spin_a", "spin_b")
    }
    moved = {
        name: watch.array(name, getattr(outcome, name), shape, given)
        for name in ("shift_a", "shift_b", "turn_a", "turn_b")
    }
    duration = watch.array("duration", outcome.duration, shape[:1], given)
    return replace(outcome, after=replace(outcome.after, **after), duration=duration, **moved)


def _flight(
    effect: FlightEffect, watch: Watch
) -> Callable[[Flying, Values], tuple[Floats, Floats]]:
    def accelerate(flying: Flying, values: Values) -> tuple[Floats, Floats]:
        found = watch.call(effect.accelerate, read_only(flying), read_only(values))
        linear, angular = _pair(watch, found, "acceleration and angular acceleration")
        shape, given = flying.velocity.shape, Given(values, lambda: finite(flying))
        return (
            watch.array("acceleration", linear, shape, given),
            watch.array("angular acceleration", angular, shape, given),
        )

    return accelerate


def _camera(effect: CameraEffect, watch: Watch) -> Callable[[Floats, CameraSetup, Values], Floats]:
    def appear(position: Floats, camera: CameraSetup, values: Values) -> Floats:
        found = watch.call(effect.appear, read_only(position), camera, read_only(values))
        given = Given(values, lambda: finite(position))
        return watch.array("position", found, position.shape, given)

    return appear


def _clock(
    effect: ClockEffect, watch: Watch
) -> Callable[[Exposure, CameraSetup, Values], tuple[Floats, Floats]]:
    def expose(exposure: Exposure, camera: CameraSetup, values: Values) -> tuple[Floats, Floats]:
        found = watch.call(effect.expose, read_only(exposure), camera, read_only(values))
        position, rotation = _pair(watch, found, "times of position and of orientation")
        shape, given = exposure.position.shape, Given(values, lambda: finite(exposure))
        return (
            watch.array("times of position", _spread(position, shape), shape, given),
            watch.array("times of orientation", _spread(rotation, shape[:3]), shape[:3], given),
        )

    return expose


def _pair(watch: Watch, found: object, names: str) -> tuple[object, object]:
    if not isinstance(found, tuple) or len(found) != 2:
        raise watch.fault(f"returned {a_value(found)}", f"return two arrays, {names}")
    return found[0], found[1]


def _spread(found: object, shape: tuple[int, ...]) -> object:
    """Return an array spread to a shape that its own broadcasts to; anything else as it is."""
    if not isinstance(found, np.ndarray):
        return found
    try:
        return np.broadcast_to(found, shape)
    except ValueError:
        return found
