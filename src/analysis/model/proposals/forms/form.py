"""A form: a coefficient of the contact as a function of something, c = c0 [1 + a f(x)].

Momentum, frame and dimension hold by construction, and a form is an effect of the contact.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from analysis.arrays import Floats
from analysis.collision.operator import Encounter, Operator, Outcome
from analysis.effects.effect import ContactEffect, Parameter, Values
from analysis.model.proposals.arguments import Argument
from analysis.model.proposals.forms.impulses import IMPULSES, TORSION, changed_outcome
from analysis.model.proposals.forms.shapes import POWER, Shape

COEFFICIENTS = ("e", "mu", "beta0")
SLOTS = (*COEFFICIENTS, TORSION, *IMPULSES)
LARGEST_CHANGE, LARGEST_POWER, LARGEST_RADIUS_M = 0.9, 4.0, 5e-3
"""Of a coefficient over the shots, of an exponent, and of a radius of contact: beyond that it is no
change of a coefficient any more."""
OF_A_PRODUCT = ("x0", "y0")
_WIDTHS = ("c", "w", "P")
"""Constants that are never below zero."""
_AMPLITUDES = {1: ("a",), 2: ("a", "b"), 3: ("a_x", "a_y", "a_z")}


@dataclass(frozen=True, slots=True, eq=False)
class ContactForm:
    """One slot, one argument or a product of two, one shape.

    Attributes
    ----------
    slot
        e, mu, beta0; impulse_n or impulse_t, along the normal and across it; or torsion, the torque
        about the normal as the radius of contact it needs.
    arguments
        One, or the two of a product.
    shape
        None: the argument's own numbers, or the product of both.
    constants
        Of the shape; of a product the zero of each argument.
    reach
        Largest size of each column over the shots of the campaign, shape (amplitudes,).
    """

    slot: str
    arguments: tuple[Argument, ...]
    shape: Shape | None
    constants: tuple[float, ...]
    reach: tuple[float, ...]

    @property
    def argument(self) -> str:
        """The argument's name; of a product both, in alphabetical order."""
        return "*".join(sorted(argument.name for argument in self.arguments))

    @property
    def shape_name(self) -> str:
        """As documents have it."""
        if self.shape is not None:
            return self.shape.name
        return "periodic" if self.argument == "normal" else "linear"

    @property
    def group(self) -> tuple[str, str]:
        """What depends on what: slot and argument."""
        return self.slot, self.argument

    @property
    def symbols(self) -> tuple[str, ...]:
        """Of the amplitudes."""
        return ("p",) if self.shape is POWER else _AMPLITUDES[len(self.reach)]

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the constants that a fit determines; of a product the zeros of both."""
        if len(self.arguments) == 2:
            return OF_A_PRODUCT
        return () if self.shape is None else self.shape.free

    def at(self, *free: float) -> ContactForm:
        """Return the form with other values of its free constants."""
        count = len(self.constants) - len(self.free)
        return replace(self, constants=(*self.constants[:count], *map(float, free)))

    def columns(self, encounter: Encounter) -> Floats:
        """Return f of every shot, shape (S, amplitudes)."""
        if len(self.arguments) == 2:
            pairs = zip(self.arguments, self.constants, strict=True)
            first, second = (_centred(argument, zero, encounter) for argument, zero in pairs)
            return first * second
        numbers = self.arguments[0].of(encounter)
        return numbers if self.shape is None else self.shape.columns(numbers[:, 0], self.constants)

    def factor(self, encounter: Encounter, values: Values) -> Floats:
        """Return c / c0 of every shot; of torsion the radius of contact, m. Shape (S,)."""
        change = self.columns(encounter) @ values
        if self.slot == TORSION:
            return np.asarray(change)
        return np.asarray(np.exp(change) if self.shape is POWER else 1.0 + change)

    def amplitudes(self) -> tuple[Parameter, ...]:
        """Return the parameters whose values are zero where nothing depends on anything."""
        most = LARGEST_RADIUS_M if self.slot == TORSION else LARGEST_CHANGE
        ends = [LARGEST_POWER if self.shape is POWER else most / max(r, 1e-12) for r in self.reach]
        return tuple(
            Parameter(
                symbol=symbol,
                unit=self.unit,
                meaning=f"change of {self.slot} with {self.argument}",
                plausible=(-end, end),
                step=1e-5 * end,
            )
            for symbol, end in zip(self.symbols, ends, strict=True)
        )

    @property
    def unit(self) -> str:
        """Of the amplitudes."""
        powers = (
            [(a.unit, 0 if a.positive else 1) for a in self.arguments]
            if len(self.arguments) == 2
            else [(self.arguments[0].unit, 0 if self.shape is None else self.shape.dimension)]
        )
        parts = ["m"] if self.slot == TORSION else []
        parts += [_inverse(unit, power) for unit, power in powers if power and unit != "1"]
        return " ".join(parts) or "1"

    def effect(self, name: str) -> ContactEffect:
        """Return the form as an effect with its amplitudes as parameters."""
        return self._effect(name, self.amplitudes(), lambda values: (self, values))

    def freed(self, name: str) -> ContactEffect:
        """Return the same with the free constants as parameters too."""
        count = len(self.symbols)
        own = self.constants[len(self.constants) - len(self.free) :]
        of = self.arguments if len(self.arguments) == 2 else self.arguments * len(own)
        scales = tuple(
            scale_of(symbol, value, argument)
            for symbol, value, argument in zip(self.free, own, of, strict=True)
        )
        return self._effect(
            name,
            (*self.amplitudes(), *scales),
            lambda values: (self.at(*values[count:]), values[:count]),
        )

    def _effect(
        self,
        name: str,
        parameters: tuple[Parameter, ...],
        parted: Callable[[Values], tuple[ContactForm, Values]],
    ) -> ContactEffect:
        def wrap(operator: Operator, values: Values) -> Operator:
            form, amplitudes = parted(values)

            def changed(encounter: Encounter) -> Outcome:
                factor = form.factor(encounter, amplitudes)
                if form.slot == TORSION:
                    return changed_outcome(TORSION, operator(encounter), encounter, factor)
                if form.slot in IMPULSES:
                    return changed_outcome(form.slot, operator(encounter), encounter, factor - 1.0)
                scaled = {form.slot: getattr(encounter, form.slot) * factor}
                return operator(replace(encounter, **scaled))

            return changed

        return ContactEffect(
            name=name,
            title=f"{self.slot} against {self.argument}, {self.shape_name}",
            parameters=parameters,
            formula=f"{self.slot} depends on {self.argument}",
            source="proposed from what a fit left over",
            gives_away=f"{self.slot} of the shots follows {self.argument}",
            wrap=wrap,
        )


def scale_of(symbol: str, value: float, argument: Argument) -> Parameter:
    """Return a constant of an argument as a parameter."""
    above_zero = symbol in _WIDTHS or argument.positive
    return Parameter(
        symbol=symbol,
        unit=argument.unit,
        meaning=f"scale of {argument.name}",
        plausible=(value - 10 * abs(value) - 1e-9, value + 10 * abs(value) + 1e-9),
        off=value,
        step=1e-4 * max(abs(value), 1e-6),
        possible=(1e-9, np.inf) if above_zero else (-np.inf, np.inf),
    )


def _centred(argument: Argument, zero: float, encounter: Encounter) -> Floats:
    numbers = argument.of(encounter)
    if argument.positive:
        return np.asarray(np.log(np.maximum(numbers, 1e-9) / zero))
    return np.asarray(numbers - zero)


def _inverse(unit: str, power: int) -> str:
    inner = f"({unit})" if "/" in unit or " " in unit else unit
    return f"{inner}^-{power}"
