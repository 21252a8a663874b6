"""Forms of the launch: what settings become at the mouths as a function of a column of the list.

Poses alone hold nothing of them, so they have a search of their own (`launch_search`), on launches
traced back to the mouths.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import LaunchEffect, Parameter, Values
from analysis.launch.muzzle import OFFSET, SIZE, Charge, Launcher, Muzzle
from analysis.model.proposals.arguments import Argument
from analysis.model.proposals.forms.form import LARGEST_CHANGE, scale_of
from analysis.model.proposals.forms.shapes import FOR_COLUMNS, POWER, Shape, spread_of

LARGEST_OFFSET_M, LARGEST_EXPONENT = 5e-3, 4.0
TRACK = "track_offset"
QUANTITIES = {"speed": (0, 1), "speed_a": (0,), "speed_b": (1,), TRACK: (OFFSET.start,)}
"""What a form changes, and where it stands in the row of a muzzle: the speeds of both pushers or of
one, in proportion, or the offset of the tracks along X, m."""
_AMPLITUDES = {1: ("a",), 2: ("a", "b")}


@dataclass(frozen=True, slots=True, eq=False)
class LaunchForm:
    """One quantity of the muzzle as a function of one column.

    Attributes
    ----------
    quantity
        A key of `QUANTITIES`.
    of
        The column.
    numbers
        Its values in the shots that are fitted, shape (S,).
    shape, constants
        The shape and its constants.
    """

    quantity: str
    of: Argument
    numbers: Floats
    shape: Shape
    constants: tuple[float, ...]

    slot = "launch"

    @property
    def argument(self) -> str:
        """As documents have it."""
        return self.of.name

    @property
    def shape_name(self) -> str:
        """As documents have it."""
        return self.shape.name

    @property
    def group(self) -> tuple[str, str]:
        """What depends on what."""
        return self.slot, self.argument

    @property
    def symbols(self) -> tuple[str, ...]:
        """Of the amplitudes."""
        return ("p",) if self._is_exponent else _AMPLITUDES[len(self.shape.codes)]

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the constants that a fit determines."""
        return self.shape.free

    @property
    def unit(self) -> str:
        """Of the amplitudes."""
        parts = ["m"] if self.quantity == TRACK else []
        power = 0 if self._is_exponent else self.shape.dimension
        if power and self.of.unit != "1":
            parts.append(f"{self.of.unit}^-{power}")
        return " ".join(parts) or "1"

    @property
    def _is_exponent(self) -> bool:
        return self.shape is POWER and self.quantity != TRACK

    def at(self, *free: float) -> LaunchForm:
        """Return the form with other values of its free constants."""
        count = len(self.constants) - len(self.free)
        return replace(self, constants=(*self.constants[:count], *map(float, free)))

    def columns(self) -> Floats:
        """Return f of every shot, shape (S, amplitudes)."""
        return self.shape.columns(self.numbers, self.constants)

    def direction(self, predicted: Muzzle) -> Floats:
        """Return the change of a muzzle's row by a change of one, shape (S, 17)."""
        row = np.zeros((len(self.numbers), SIZE))
        places = list(QUANTITIES[self.quantity])
        row[:, places] = 1.0 if self.quantity == TRACK else predicted.row[:, places]
        return row

    def amplitudes(self) -> tuple[Parameter, ...]:
        """Return the parameters whose values are zero where nothing depends on the column."""
        most = LARGEST_OFFSET_M if self.quantity == TRACK else LARGEST_CHANGE
        reach = np.abs(self.columns()).max(axis=0)
        ends = [LARGEST_EXPONENT if self._is_exponent else most / max(r, 1e-12) for r in reach]
        meaning = f"change of {self.quantity} with {self.argument}"
        return tuple(
            Parameter(symbol, self.unit, meaning, (-end, end), step=1e-5 * end)
            for symbol, end in zip(self.symbols, map(float, ends), strict=True)
        )

    def effect(self, name: str) -> LaunchEffect:
        """Return the form as an effect of these shots."""
        return self._effect(name, self.amplitudes(), lambda values: (self, values))

    def freed(self, name: str) -> LaunchEffect:
        """Return the same with the free constants as parameters too."""
        count = len(self.symbols)
        own = self.constants[len(self.constants) - len(self.free) :]
        scales = [scale_of(s, value, self.of) for s, value in zip(self.free, own, strict=True)]
        return self._effect(
            name,
            (*self.amplitudes(), *scales),
            lambda values: (self.at(*values[count:]), values[:count]),
        )

    def _changed(self, muzzle: Muzzle, values: Values) -> Muzzle:
        change = self.columns() @ values
        row = muzzle.row.copy()
        places = list(QUANTITIES[self.quantity])
        if self.quantity == TRACK:
            row[:, places] += change[:, None]
        else:
            factor = np.exp(change) if self._is_exponent else 1.0 + change
            row[:, places] *= factor[:, None]
        return Muzzle.of_row(row)

    def _effect(
        self,
        name: str,
        parameters: tuple[Parameter, ...],
        parted: Callable[[Values], tuple[LaunchForm, Values]],
    ) -> LaunchEffect:
        def wrap(launcher: Launcher, values: Values) -> Launcher:
            form, amplitudes = parted(values)

            def changed(charge: Charge) -> Muzzle:
                return form._changed(launcher(charge), amplitudes)

            return changed

        return LaunchEffect(
            name=name,
            title=f"{self.quantity} against {self.argument}, {self.shape_name}",
            parameters=parameters,
            formula=f"{self.quantity} depends on {self.argument}",
            source="proposed from what a fit of the launches left over",
            gives_away=f"{self.quantity} of the launches follows {self.argument}",
            wrap=wrap,
        )


def launch_forms(arguments: Sequence[tuple[Argument, Floats]]) -> list[LaunchForm]:
    """Return every quantity with every column, values of shape (S,), in every shape."""
    return [
        LaunchForm(quantity, argument, numbers, shape, constants)
        for quantity in QUANTITIES
        for argument, numbers in arguments
        for shape in (*FOR_COLUMNS, *((POWER,) if argument.positive else ()))
        for constants in shape.grid(spread_of(numbers), 1)
    ]
