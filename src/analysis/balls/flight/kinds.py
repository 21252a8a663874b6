"""The drag of a ball whose mass is not stated, by the kinds of balls of its size and its flights.

Balls of 40 mm are full of air or solid, and lie 1.6 spreads to both sides of what is believed of a
ball of any size. Flights say the drag itself with an error; what is believed of its logarithm is a
mixture of normal distributions. The prior that is given back is the normal one with which the
flights have the mean drag and its variance that they have with the mixture (moments matched, as in
expectation propagation; Minka, 2001): of the drag and not of its logarithm, as e changes with it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from analysis.arrays import Floats
from analysis.balls.flight import path
from analysis.balls.flight.flights import Flights
from analysis.balls.flight.known import UNKNOWN_DENSITY, UNKNOWN_SPREAD, Ball

MOST_SPREAD = 1.5
"""Of a prior: where flights are less sure with the mixture than alone."""
LEAST_SHARE = 1e-30
GRID = np.exp(np.linspace(-10.0, 2.0, 2401))
"""1/m, evenly spread in the logarithm: from a ball of lead to one of nothing."""


@dataclass(frozen=True, slots=True)
class Kind:
    """Balls of one make.

    Attributes
    ----------
    least_m, most_m
        Their diameters.
    density, spread
        kg/m^3, and the spread of its logarithm.
    """

    least_m: float
    most_m: float
    density: float
    spread: float


ANY = Kind(0.0, math.inf, UNKNOWN_DENSITY, UNKNOWN_SPREAD)
TABLE_TENNIS = Kind(0.036, 0.0445, 82.0, 0.15)
INFLATED = Kind(0.15, math.inf, 80.0, 0.35)
"""From a volleyball (56) to a handball (125); footballs and basketballs have 75 to 85."""
KINDS = (ANY, TABLE_TENNIS, INFLATED)


def told_drag(ball: Ball, flights: Flights, prior: tuple[float, float]) -> tuple[float, float]:
    """Return what is believed of a ball's drag, 1/m, once its flights have said what they do.

    Parameters
    ----------
    ball
        Without a density.
    flights
        Of it.
    prior
        Drag, 1/m, and the spread of its logarithm, with which they were fitted.

    Returns
    -------
    The same for the next fit.
    """
    kinds = [kind for kind in KINDS if kind.least_m <= ball.diameter_m <= kind.most_m]
    if kinds == [ANY]:
        return prior
    drag = float(flights.values[path.DRAG]) * flights.scale_px_per_m
    # The covariance holds the longer side of the logarithm's error.
    sigma = math.log1p(math.sqrt(float(flights.covariance[path.DRAG, path.DRAG])))
    # What the flights say alone: the derivative, and the curvature, of their misfit to the drag.
    weight = max(0.0, sigma**-2 - prior[1] ** -2) / drag**2
    pull = math.log(drag / prior[0]) / prior[1] ** 2 / drag + weight * drag
    believed = sum(_believed(ball, kind) for kind in kinds)
    told = np.log(believed) - 0.5 * weight * GRID**2 + pull * GRID
    shares = np.exp(told - told.max())
    shares /= shares.sum()
    mean = float(shares @ GRID)
    spread = math.sqrt(float(shares @ (GRID - mean) ** 2))
    # The error of a logarithm has the longer side of its number's.
    own = max(math.log1p(spread / mean) ** -2 - weight * mean**2, MOST_SPREAD**-2)
    return mean * math.exp(-(pull - weight * mean) * mean / own), own**-0.5


def _believed(ball: Ball, kind: Kind) -> Floats:
    """Return how likely each drag of the grid is of balls of one kind."""
    drag, spread = replace(ball, density=kind.density).drag_per_m()
    spread = math.hypot(spread, kind.spread)
    return np.asarray(np.exp(-0.5 * (np.log(GRID / drag) / spread) ** 2) / spread) + LEAST_SHARE
