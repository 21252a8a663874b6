"""Colours inside and outside of a circle: a ball covers its ground, a shadow only darkens it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Singles
from analysis.balls.discs.along import through

OF_STEP = 0.3
"""Share of the median step that agrees with it, and within which a colour is the ground's."""
LEAST, MOST_HOLLOW = 0.05, 3.0
"""What is added to a share before its logarithm is taken; steps that count at most."""
SHADE, TINT = (0.3, 0.95), 0.45
"""Share of its ground's light that a shadow leaves, and share of its step that may be of another
colour: lamps differ a little."""


@dataclass(frozen=True, slots=True, eq=False)
class Colours:
    """Colours of a circle's sectors at both sides of its rim.

    Attributes
    ----------
    inside, outside
        Shape (sectors, channels).
    shown, clear
        Which sectors are in the window, and which of these no surer disc hides; shape (sectors,).
    middle
        Median about the centre, shape (channels,).
    """

    inside: Floats
    outside: Floats
    shown: NDArray[np.bool_]
    clear: NDArray[np.bool_]
    middle: Floats

    def _own(self) -> Floats:
        return np.asarray(np.median(self.inside[self.shown], axis=0))

    def _steps(self, sectors: NDArray[np.bool_]) -> Floats:
        return self.inside[sectors] - self.outside[sectors]

    def step(self, sectors: NDArray[np.bool_]) -> float:
        """Return the median size of the step at the rim."""
        return float(np.median(np.linalg.norm(self._steps(sectors), axis=1))) + 1e-9

    def agree(self) -> float:
        """Return the share of sectors whose step is as the median one."""
        steps = self._steps(self.shown)
        step = np.median(steps, axis=0)
        return float((steps @ step > OF_STEP * (step @ step)).mean())

    def uneven(self) -> float:
        """Return the logarithm of the median difference of the inside along the rim, in steps."""
        off = np.linalg.norm(self.inside[self.shown] - self._own(), axis=1)
        return math.log(LEAST + float(np.median(off)) / self.step(self.shown))

    def solid(self) -> float:
        """Return the logarithm of how far the middle differs from the outside, in steps."""
        off = self.middle - np.median(self.outside[self.shown], axis=0)
        return math.log(LEAST + min(1.0, float(np.linalg.norm(off)) / self.step(self.shown)))

    def hollow(self) -> float:
        """Return how far the middle differs from what is within the rim, in steps."""
        off = float(np.linalg.norm(self.middle - self._own()))
        return min(MOST_HOLLOW, off / self.step(self.shown))

    def open(self, window: Singles, circle: Floats) -> float:
        """Return the logarithm of the share of the inside that has the colour of what is outside.

        Colours of surer discs that hide a part of the circle are none of its ground.
        """
        ground = np.median(self.outside[self.clear], axis=0)
        outside = np.where(self.clear[:, None], self.outside, ground)
        near = OF_STEP * self.step(self.clear)
        return math.log(LEAST + float(through(window, circle, outside, ground, near)))

    def shaded(self) -> bool:
        """Return whether the inside is the ground with less light, as in a shadow.

        In a single channel everything is of one colour, and nothing tells a shadow.
        """
        if self.inside.shape[1] == 1:
            return False
        own, ground = (np.median(side[self.clear], axis=0) for side in (self.inside, self.outside))
        left = float(own @ ground) / (float(ground @ ground) + 1e-9)
        tint = float(np.linalg.norm(own - left * ground))
        return SHADE[0] < left < SHADE[1] and tint < TINT * float(np.linalg.norm(own - ground))

    def is_other(self, colour: Floats) -> bool:
        """Return whether a colour differs from the inside by more than the step at the rim."""
        off = colour - np.median(self.inside[self.clear], axis=0)
        return float(np.linalg.norm(off)) > self.step(self.clear)
