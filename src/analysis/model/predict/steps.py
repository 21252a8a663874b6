"""What a small step of one parameter of flight, camera, body or clock does to frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import (
    BodyEffect,
    CameraEffect,
    ClockEffect,
    Effect,
    FlightEffect,
    OrientationEffect,
)
from analysis.model.predict.comparison import Frames
from analysis.model.predict.prediction import Change, appear, displaced, exposed, rate
from analysis.model.predict.theory import Theory


@dataclass(frozen=True, slots=True, eq=False)
class Unmoved:
    """A theory and what frames show of it: where the steps of all parameters start."""

    theory: Theory
    here: Frames

    @property
    def position(self) -> Floats:
        """Centres of mass, m, with what small forces do on the way, shape (S, F, 2, 3)."""
        flown, flight = self.here.flown, self.theory.flight
        return flown.position + self.here.way.pushed(flight)[0] if flight else flown.position

    def change(self, moved: Theory, effect: Effect) -> Change:
        """Return what a theory with other values of an effect changes.

        Positions, m, and orientations, rad, shape (S, F, 2, 3); None: no orientation.
        """
        if isinstance(effect, ClockEffect):
            return self._later(moved)
        if isinstance(effect, OrientationEffect):
            return self._turned(moved)
        way, turned = self.here.way, None
        position = self.position
        if isinstance(effect, FlightEffect):
            # An error of the air may be in beside a candidate of the same name.
            old, new = ([(e, v) for e, v in t.flight if e is effect] for t in (self.theory, moved))
            pushed, turned = way.pushed(new)
            before, turned_before = way.pushed(old)
            position, turned = position + (pushed - before), _less(turned, turned_before)
        elif not isinstance(effect, CameraEffect | BodyEffect):
            raise TypeError(f"effect {effect.name!r} acts in no known stage")
        position = displaced(way.data, way.flown, position, moved.body)
        return appear(way.data, position, moved.camera) - self.here.poses.position, turned

    def _turned(self, moved: Theory) -> Change:
        """Return what other turns of the orientations that are seen do, to first order."""
        where = self.here.poses.position
        old, new = (0.0 if r is None else r for r in (self.theory.orientation, moved.orientation))
        return np.zeros_like(where), np.broadcast_to(new - old, where.shape)

    def _later(self, moved: Theory) -> Change:
        """Return what other true times do, to first order."""
        data, flown = self.here.way.data, self.here.way.flown
        before, after = (
            exposed(data, flown.stated, flown.position, t.clock) for t in (self.theory, moved)
        )
        place = self.position + rate(data, flown) * (after.position - before.position)
        place = displaced(data, flown, place, self.theory.body)
        change = appear(data, place, self.theory.camera) - self.here.poses.position
        return change, flown.spin * (after.rotation - before.rotation)[..., None]


def _less(turned: Floats | None, before: Floats | None) -> Floats | None:
    if before is None:
        return turned
    return -before if turned is None else turned - before
