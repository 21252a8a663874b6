"""A function of the user's file, called so that what goes wrong is named with file and line."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.effects.effect import Effect, Values
from analysis.effects.own.fault import EffectFault, Fault, exception_text, line_in

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
