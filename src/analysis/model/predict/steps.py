"""What a small step of one parameter of flight, camera, body or clock does to frames."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from analysis.effects.effect import BodyEffect, CameraEffect, ClockEffect, Effect, FlightEffect
from analysis.model.data.poses import PoseData
from analysis.model.predict.comparison import Frames
from analysis.model.predict.prediction import (
    OnWay,
    appear,
    displaced,
    exposed,
    perturbation,
    rate,
)
from analysis.model.predict.theory import Theory

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Unmoved:
    """A theory and what frames show of it: where the steps of all parameters start."""

    data: PoseData
    theory: Theory
    here: Frames

    @cached_property
    def on_way(self) -> OnWay:
        """What all small forces in flight act on."""
        return OnWay(self.data, self.here.flown)

    @cached_property
    def position(self) -> Floats:
        """Centres of mass, m, with what small forces do on the way, shape (S, F, 2, 3)."""
        flown, flight = self.here.flown, self.theory.flight
        return flown.position + perturbation(flown, self.on_way, flight)[0]

    def change(self, moved: Theory, effect: Effect) -> tuple[Floats, Floats | None]:
        """Return what a theory with other values of an effect changes.

        Positions, m, and orientations, rad, shape (S, F, 2, 3); None: no orientation.
        """
        if isinstance(effect, ClockEffect):
            return self._later(moved)
        position, turned = self.position if self.theory.flight else self.here.flown.position, None
        if isinstance(effect, FlightEffect):
            old = [(e, v) for e, v in self.theory.flight if e is effect]
            new = [(e, v) for e, v in moved.flight if e is effect]
            push, turned = perturbation(self.here.flown, self.on_way, new)
            if old:
                before = perturbation(self.here.flown, self.on_way, old)
                push, turned = push - before[0], turned - before[1]
            position = position + push
        elif not isinstance(effect, CameraEffect | BodyEffect):
            raise TypeError(f"effect {effect.name!r} acts in no known stage")
        position = displaced(self.data, self.here.flown, position, moved.body)
        return appear(self.data, position, moved.camera) - self.here.poses.position, turned

    def _later(self, moved: Theory) -> tuple[Floats, Floats]:
        """Return what other true times do, to first order."""
        data, flown = self.data, self.here.flown
        before, after = (
            exposed(data, flown.stated, flown.position, t.clock) for t in (self.theory, moved)
        )
        place = self.position if self.theory.flight else flown.position
        place = place + rate(data, flown) * (after.position - before.position)
        place = displaced(data, flown, place, self.theory.body)
        change = appear(data, place, self.theory.camera) - self.here.poses.position
        return change, flown.spin * (after.rotation - before.rotation)[..., None]
