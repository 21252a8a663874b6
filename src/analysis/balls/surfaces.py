"""What a ball bounces off in one film: a floor, table or plate, and walls beside it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from analysis.arrays import Floats
from analysis.balls.flight.flights import STEEP, Start
from analysis.balls.seen.arcs import Chain

QUARTER = 0.5 * math.pi


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Flights between bounces off one surface.

    Attributes
    ----------
    chain
        Of the flights before, between and after these bounces.
    lean
        Angle of the surface against the horizontal, rad, as far as it is known: as stated of a
        plate, else 0; a quarter turn of a wall, positive on the left of the flight.
    """

    chain: Chain
    lean: float

    def start(self, fall: Floats, own_fall: float | None = None) -> Start:
        """Return where a fit of these bounces begins.

        Parameters
        ----------
        fall
            Of the search, px/s^2 in (row, column).
        own_fall
            As `Start` has it.
        """
        chain = self.chain
        return Start(chain.times_s, chain.places, *chain.speeds(fall), own_fall, self.lean)

    @property
    def frames(self) -> int:
        """Return in how many frames the ball flies."""
        return sum(len(arc.frames) for arc in self.chain.arcs)


def parts(chain: Chain, fall: Floats, plate_lean: float | None = None) -> list[Part]:
    """Return the flights of a chain by what the ball bounces off, the longest of a plate first.

    `plate_lean` is what is stated of the plate, rad; None: nothing.

    Off a wall a ball changes its speed across more than that along gravity, and turns round, but
    does not come down and go up, as off a floor that turns it round by its spin. Each
    bounce off a wall is a part of its own: nothing falls back to a wall.
    """
    lean = 0.0 if plate_lean is None or abs(plate_lean) > STEEP else plate_lean
    before, after = chain.speeds(fall)
    jump = np.abs(after - before)
    up = (before[:, 0] > 0) & (after[:, 0] < 0)
    walls = (jump[:, 1] > jump[:, 0]) & (before[:, 1] * after[:, 1] < 0) & ~up
    if not walls.any():
        return [Part(chain, lean)]
    found = [
        Part(_between(chain, k, k + 1), -math.copysign(QUARTER, float(before[k, 1])))
        for k in np.flatnonzero(walls).tolist()
    ]
    edges = [-1, *np.flatnonzero(walls).tolist(), len(walls)]
    plates = [Part(_between(chain, a + 1, b), lean) for a, b in pairwise(edges) if b > a + 1]
    return [*sorted(plates, key=lambda part: -part.frames), *found]


def _between(chain: Chain, first: int, last: int) -> Chain:
    """Return the flights about some bounces, from the first up to the last."""
    own = slice(first, last)
    return Chain(chain.arcs[first : last + 1], chain.times_s[own], chain.places[own])
