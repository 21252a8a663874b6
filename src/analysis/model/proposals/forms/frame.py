"""Forms of the camera and the clock: pictures that err with the place, frames with the time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import CameraEffect, ClockEffect, Exposure, Parameter, Values
from analysis.setup import CameraSetup

Kind = Literal["linear", "power", "periodic"]

AXES = "xyz"
FREQUENCIES_HZ = (50.0, 75.0, 100.0, 120.0, 160.0)
_LIMITS = {
    ("camera", "linear"): (0.05, 1e-6, "1"),
    ("camera", "power"): (2.0, 1e-4, "m^-1"),
    ("clock", "power"): (1.0, 1e-4, "s^-1"),
    ("clock", "periodic"): (1e-4, 1e-8, "s"),
}
"""Ends of the believed range, step for differences, unit of the amplitude."""


@dataclass(frozen=True, slots=True, eq=False)
class FrameForm:
    """A displacement of the picture along one axis, or of the time of the frames.

    Attributes
    ----------
    slot
        camera or clock.
    kind
        Of the camera linear or a square in the place, of the clock a square in the time from the
        shot's first frame, or periodic.
    along, by
        Axis that is displaced and axis whose place it follows; of the clock 0.
    constants
        Frequency of a periodic clock, Hz.
    """

    slot: Literal["camera", "clock"]
    kind: Kind
    along: int = 0
    by: int = 0
    constants: tuple[float, ...] = ()

    @property
    def argument(self) -> str:
        """As documents have it."""
        return f"contact_{AXES[self.by]}" if self.slot == "camera" else "time"

    @property
    def shape_name(self) -> str:
        """As documents have it."""
        return self.kind

    @property
    def group(self) -> tuple[str, str]:
        """What depends on what."""
        return self.slot, self.argument

    @property
    def symbols(self) -> tuple[str, ...]:
        """Of the amplitudes."""
        return ("a", "b") if self.kind == "periodic" else ("a",)

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the constants that a fit determines."""
        return ("f",) if self.kind == "periodic" else ()

    @property
    def unit(self) -> str:
        """Of the amplitudes."""
        return _LIMITS[self.slot, self.kind][2]

    def at(self, *free: float) -> FrameForm:
        """Return the form with other values of its free constants."""
        return replace(self, constants=tuple(map(float, free)))

    def effect(self, name: str) -> CameraEffect | ClockEffect:
        """Return the form as an effect with its amplitudes as parameters."""
        return self._effect(name, self._amplitudes(), lambda values: (self, values))

    def freed(self, name: str) -> CameraEffect | ClockEffect:
        """Return the same with the frequency as a parameter too."""
        count = len(self.symbols)
        scales = tuple(
            Parameter("f", "Hz", "frequency", (1.0, 500.0), off=value, step=1e-3)
            for value in self.constants
        )
        return self._effect(
            name,
            (*self._amplitudes(), *scales),
            lambda values: (self.at(*values[count:]) if scales else self, values[:count]),
        )

    def displaced(self, position: Floats, values: Values) -> Floats:
        """Return where the images show centres, m, shape (..., 3)."""
        shifted = position.copy()
        place = position[..., self.by]
        shifted[..., self.along] += values[0] * (place if self.kind == "linear" else place**2)
        return shifted

    def true_times(self, times_s: Floats, values: Values) -> Floats:
        """Return true times of the frames, s, shape (S, F)."""
        if self.kind == "power":
            return np.asarray(times_s + values[0] * times_s**2)
        phase = 2 * np.pi * self.constants[0] * times_s
        return np.asarray(times_s + values[0] * np.sin(phase) + values[1] * np.cos(phase))

    def _amplitudes(self) -> tuple[Parameter, ...]:
        end, step, unit = _LIMITS[self.slot, self.kind]
        meaning = f"error of the {self.slot} with {self.argument}"
        return tuple(
            Parameter(symbol, unit, meaning, (-end, end), step=step) for symbol in self.symbols
        )

    def _effect(
        self,
        name: str,
        parameters: tuple[Parameter, ...],
        parted: Callable[[Values], tuple[FrameForm, Values]],
    ) -> CameraEffect | ClockEffect:
        def appear(position: Floats, camera: CameraSetup, values: Values) -> Floats:
            del camera
            form, amplitudes = parted(values)
            return form.displaced(position, amplitudes)

        def expose(
            exposure: Exposure, camera: CameraSetup, values: Values
        ) -> tuple[Floats, Floats]:
            del camera
            form, amplitudes = parted(values)
            true = form.true_times(exposure.times_s, amplitudes)[..., None]
            return true[..., None], true

        title = f"{self.slot} against {self.argument}, {self.kind}"
        formula = f"the {self.slot} errs with {self.argument}"
        source = "proposed from what a fit left over"
        betrays = f"what is left follows {self.argument} in all shots alike"
        if self.slot == "camera":
            return CameraEffect(
                name=name,
                title=title,
                parameters=parameters,
                formula=formula,
                source=source,
                gives_away=betrays,
                appear=appear,
            )
        return ClockEffect(
            name=name,
            title=title,
            parameters=parameters,
            formula=formula,
            source=source,
            gives_away=betrays,
            expose=expose,
        )


def frame_forms() -> list[FrameForm]:
    """Return the errors of pictures and times that are looked for."""
    kinds: tuple[Kind, ...] = ("linear", "power")
    found = [
        FrameForm("camera", kind, along, by)
        for kind in kinds
        for along in range(3)
        for by in range(3)
    ]
    found.append(FrameForm("clock", "power"))
    return found + [FrameForm("clock", "periodic", constants=(f,)) for f in FREQUENCIES_HZ]
