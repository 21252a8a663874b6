"""What a campaign is compared with: the collision law and the effects that have been added."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.collision.operator import Operator, WaltonLaw, walton
from analysis.effects.effect import (
    BodyEffect,
    CameraEffect,
    ClockEffect,
    ContactEffect,
    Effect,
    FlightEffect,
    Values,
)

Floats = NDArray[np.float64]

LAW = ("e", "mu", "beta0")
_LAW_STEP = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Active:
    """An effect that takes part, at some values of its parameters."""

    effect: Effect
    values: Values


@dataclass(frozen=True, slots=True, eq=False)
class Theory:
    """Law and effects; every parameter that all shots share, in one vector."""

    law: WaltonLaw
    active: tuple[Active, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each parameter: e, mu, beta0, then `effect.symbol`."""
        added = [f"{a.effect.name}.{p.symbol}" for a in self.active for p in a.effect.parameters]
        return (*LAW, *added)

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each parameter."""
        return ("1",) * 3 + tuple(p.unit for a in self.active for p in a.effect.parameters)

    @property
    def vector(self) -> Floats:
        """All parameters, shape (P,)."""
        law = [self.law.e, self.law.mu, self.law.beta0]
        return np.concatenate([law, *(a.values for a in self.active)])

    @property
    def steps(self) -> Floats:
        """A step for differences of each parameter, shape (P,)."""
        added = [p.step for a in self.active for p in a.effect.parameters]
        return np.array([_LAW_STEP] * 3 + added)

    def at(self, vector: Floats) -> Theory:
        """Return the same theory at other values, shape (P,)."""
        start, active = 3, []
        for a in self.active:
            stop = start + len(a.values)
            active.append(replace(a, values=vector[start:stop]))
            start = stop
        return Theory(WaltonLaw(*map(float, vector[:3])), tuple(active))

    def with_effect(self, effect: Effect) -> Theory:
        """Return the theory with one more effect, at the values where it is off.

        One that the new effect contains makes room for it, and hands on what its parameters are.
        """
        values = effect.off
        for contained in self.active:
            if contained.effect.name in effect.contains:
                found = dict(
                    zip(
                        (p.symbol for p in contained.effect.parameters),
                        contained.values,
                        strict=True,
                    )
                )
                values = np.array(
                    [found.get(p.symbol, v) for p, v in zip(effect.parameters, values, strict=True)]
                )
        left = tuple(a for a in self.active if a.effect.name not in effect.contains)
        return replace(self, active=(*left, Active(effect, values)))

    def without_effect(self, name: str) -> Theory:
        """Return the theory less one effect."""
        return replace(self, active=tuple(a for a in self.active if a.effect.name != name))

    @property
    def operator(self) -> Operator:
        """The collision operator with all contact effects wrapped round it."""
        operator: Operator = walton
        for a in self.active:
            if isinstance(a.effect, ContactEffect):
                operator = a.effect.wrap(operator, a.values)
        return operator

    @property
    def flight(self) -> tuple[tuple[FlightEffect, Values], ...]:
        """Effects of the flight."""
        return tuple(
            (a.effect, a.values) for a in self.active if isinstance(a.effect, FlightEffect)
        )

    @property
    def camera(self) -> tuple[tuple[CameraEffect, Values], ...]:
        """Effects of the camera."""
        return tuple(
            (a.effect, a.values) for a in self.active if isinstance(a.effect, CameraEffect)
        )

    @property
    def body(self) -> tuple[tuple[BodyEffect, Values], ...]:
        """Effects of the bodies' turning."""
        return tuple((a.effect, a.values) for a in self.active if isinstance(a.effect, BodyEffect))

    @property
    def clock(self) -> tuple[tuple[ClockEffect, Values], ...]:
        """Effects of the clock."""
        return tuple((a.effect, a.values) for a in self.active if isinstance(a.effect, ClockEffect))
