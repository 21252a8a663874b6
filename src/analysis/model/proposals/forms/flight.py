"""Forces in flight that no catalogue holds: between the spheres, along the velocity, everywhere."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import FlightEffect, Flying, Parameter, Values

Kind = Literal["central", "central-exponential", "velocity", "uniform"]

NODES = 8
"""Instants of a flight: a power of the distance changes by a thousand on the way."""
REFERENCE_SPEED = 1.0
LARGEST_M_PER_S2 = 100.0
_NAMES = {
    "central": ("distance", "power"),
    "central-exponential": ("distance", "exponential"),
    "velocity": ("velocity", "power"),
    "uniform": ("uniform", "linear"),
}


@dataclass(frozen=True, slots=True, eq=False)
class FlightForm:
    """A force on both spheres in flight, as the acceleration of a sphere of the first's mass.

    Attributes
    ----------
    kind
        Toward the other sphere as a power of the distance or fading with the gap, along the
        velocity as a power of the speed, or the same everywhere.
    constants
        The exponent or the length, m; of a uniform field none.
    touching, mass
        Distance of the centres at touch, m, and mass of sphere a, kg.
    """

    kind: Kind
    constants: tuple[float, ...]
    touching: float
    mass: float

    slot = "flight"

    @property
    def argument(self) -> str:
        """As documents have it."""
        return _NAMES[self.kind][0]

    @property
    def shape_name(self) -> str:
        """As documents have it."""
        return _NAMES[self.kind][1]

    @property
    def group(self) -> tuple[str, str]:
        """What depends on what."""
        return self.slot, self.argument

    @property
    def symbols(self) -> tuple[str, ...]:
        """Of the amplitudes."""
        return ("g_x", "g_y", "g_z") if self.kind == "uniform" else ("k",)

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the constants that a fit determines."""
        names: dict[str, tuple[str, ...]] = {
            "central": ("p",),
            "central-exponential": ("c",),
            "velocity": ("q",),
        }
        return names.get(self.kind, ())

    @property
    def unit(self) -> str:
        """Of the amplitudes."""
        return "m/s^2"

    def at(self, *free: float) -> FlightForm:
        """Return the form with other values of its free constants."""
        return replace(self, constants=tuple(map(float, free)))

    def accelerate(self, flying: Flying, values: Values) -> Floats:
        """Return accelerations, m/s^2, shape (..., 3)."""
        if self.kind == "uniform":
            return np.asarray(np.broadcast_to(values, flying.velocity.shape))
        if self.kind == "velocity":
            speed = _lengths(flying.velocity).clip(min=1e-6)
            size = (speed / REFERENCE_SPEED) ** self.constants[0]
            return np.asarray(-values[0] * size * flying.velocity / speed)
        if flying.partner is None:
            return np.zeros_like(flying.position)
        apart = flying.partner - flying.position
        distance = _lengths(apart).clip(min=0.5 * self.touching)
        if self.kind == "central":
            size = (self.touching / distance) ** self.constants[0]
        else:
            size = np.exp(-(distance - self.touching) / self.constants[0])
        return np.asarray(values[0] * (self.mass / flying.body.mass) * size * apart / distance)

    def effect(self, name: str) -> FlightEffect:
        """Return the force as an effect with its amplitudes as parameters."""
        return self._effect(name, self._amplitudes(), lambda values: (self, values))

    def freed(self, name: str) -> FlightEffect:
        """Return the same with the exponent or the length as a parameter too."""
        count = len(self.symbols)
        length = self.kind == "central-exponential"
        scales = tuple(
            Parameter(
                symbol=symbol,
                unit="m" if length else "1",
                meaning="length over which it fades" if length else "exponent",
                plausible=(0.0, 1.0) if length else (-20.0, 20.0),
                off=value,
                step=1e-7 if length else 1e-4,
                possible=(1e-4, 10.0) if length else (-30.0, 30.0),
            )
            for symbol, value in zip(self.free, self.constants, strict=True)
        )
        return self._effect(
            name,
            (*self._amplitudes(), *scales),
            lambda values: (self.at(*values[count:]) if scales else self, values[:count]),
        )

    def _amplitudes(self) -> tuple[Parameter, ...]:
        return tuple(
            Parameter(
                symbol=symbol,
                unit=self.unit,
                meaning="acceleration of sphere a",
                plausible=(-LARGEST_M_PER_S2, LARGEST_M_PER_S2),
                step=1e-3,
            )
            for symbol in self.symbols
        )

    def _effect(
        self,
        name: str,
        parameters: tuple[Parameter, ...],
        parted: Callable[[Values], tuple[FlightForm, Values]],
    ) -> FlightEffect:
        def accelerate(flying: Flying, values: Values) -> tuple[Floats, Floats]:
            form, amplitudes = parted(values)
            return form.accelerate(flying, amplitudes), np.zeros_like(flying.spin)

        return FlightEffect(
            name=name,
            title=f"force in flight against {self.argument}, {self.shape_name}",
            parameters=parameters,
            formula=f"acceleration depends on {self.argument}",
            source="proposed from what a fit left over",
            gives_away=f"flight bends with {self.argument}",
            accelerate=accelerate,
            nodes=NODES if self.kind.startswith("central") else 2,
        )


def _lengths(vectors: Floats) -> Floats:
    """Return lengths of vectors (..., 3), shape (..., 1)."""
    return np.asarray(np.sqrt(np.einsum("...i,...i->...", vectors, vectors))[..., None])


def flight_forms(touching: float, mass: float) -> list[FlightForm]:
    """Return the forces that are looked for, with the exponents and lengths that are tried."""
    found = [
        FlightForm("central", (p,), touching, mass) for p in (0.0, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0)
    ]
    found += [
        FlightForm("central-exponential", (share * touching,), touching, mass)
        for share in (0.1, 0.3, 1.0)
    ]
    found += [FlightForm("velocity", (q,), touching, mass) for q in (0.0, 1.0, 2.0, 3.0)]
    return [*found, FlightForm("uniform", (), touching, mass)]
