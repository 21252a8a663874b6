"""What kinds of balls there are: how long they stay in contact, and the drag of unknown masses.

Balls of 40 mm are full of air or solid, and lie 1.6 spreads to both sides of what is believed of a
ball of any size. Flights say the drag itself with an error; what is believed of its logarithm is a
mixture of normal distributions. The prior that is given back is the normal one with which the
flights have the mean drag and its variance that they have with the mixture (moments matched, as in
expectation propagation; Minka, 2001): of the drag and not of its logarithm, as e changes with it.

Contacts of balls that are full of air last longer than those of most solid ones: against a flat
plate a shell of the radius R under the pressure p is a spring of 2 pi R p, with which half a period
of 0.43 kg, 110 mm and 0.8 bar is 8.8 ms.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from analysis.arrays import Floats
from analysis.balls.flight import path
from analysis.balls.flight.flights import Flights
from analysis.balls.flight.known import UNKNOWN_DENSITY, UNKNOWN_SPREAD, Ball

MOST_SPREAD = 1.05
"""Of a prior: little more than that of balls of any kind. Flights that lie between two kinds are
less sure with both than alone, and ask for more: they have the likelier one's."""
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
    stay, stay_sigma
        Duration of contacts over the ball's diameter, s/m, and its standard error.
    share
        How many balls of that size are of this make, for each one of `ANY`.
    """

    least_m: float
    most_m: float
    density: float
    spread: float
    stay: float
    stay_sigma: float
    share: float = 1.0


ANY = Kind(0.0, math.inf, UNKNOWN_DENSITY, UNKNOWN_SPREAD, 0.0, 0.025)
"""Contacts of balls of 20 mm at 1 m/s: from hard ones' 0.05 ms to soft ones' 2 ms. No contact lasts
for less than no time."""
TABLE_TENNIS = Kind(0.036, 0.0445, 82.0, 0.15, 0.018, 0.008)
SQUASH = Kind(0.038, 0.042, 700.0, 0.04, 0.05, 0.045)
"""Contacts of a squash ball last 4 ms, those of a wooden ball of this size and density hardly."""
TENNIS = Kind(0.062, 0.071, 370.0, 0.08, 0.07, 0.015)
"""By the rules 65.4 to 68.6 mm and 56 to 59.4 g; contacts of some 5 ms (Cross, 1999)."""
INFLATED = Kind(0.15, math.inf, 80.0, 0.35, 0.055, 0.02, share=9.0)
"""From a volleyball (56) to a handball (125); footballs and basketballs have 75 to 85. By mass and
pressure a football's contacts last 9 ms, a basketball's and a volleyball's 12, a handball's 14."""
KINDS = (ANY, TABLE_TENNIS, SQUASH, TENNIS, INFLATED)
STATED_SPREAD = 0.05
"""Of a stated density's logarithm: diameters are measured by hand."""


def contact_time(ball: Ball) -> tuple[float, float]:
    """Return how long a ball's contacts last before a film is seen, s, and the standard error.

    Of a ball that may be of several kinds mean and variance are those of all together.
    """
    kinds = _kinds(ball)
    shares = np.array([_share(ball, kind) for kind in kinds])
    shares /= shares.sum()
    stays = np.array([kind.stay for kind in kinds])
    sigmas = np.array([kind.stay_sigma for kind in kinds])
    mean = float(shares @ stays)
    spread = math.sqrt(float(shares @ (sigmas**2 + (stays - mean) ** 2)))
    return mean * ball.diameter_m, spread * ball.diameter_m


def _kinds(ball: Ball) -> list[Kind]:
    return [kind for kind in KINDS if kind.least_m <= ball.diameter_m <= kind.most_m]


def _share(ball: Ball, kind: Kind) -> float:
    """Return how likely the stated density, if any, is of balls of one kind; not normalised."""
    if ball.density is None:
        return kind.share
    spread = math.hypot(kind.spread, STATED_SPREAD)
    apart = math.log(ball.density / kind.density) / spread
    return kind.share * math.exp(-0.5 * apart**2) / spread + LEAST_SHARE


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
    kinds = _kinds(ball)
    if kinds == [ANY]:
        return prior
    drag = float(flights.values[path.DRAG]) * flights.scale_px_per_m
    # The covariance holds the longer side of the logarithm's error.
    sigma = math.log1p(math.sqrt(float(flights.covariance[path.DRAG, path.DRAG])))
    # What the flights say alone: the derivative, and the curvature, of their misfit to the drag.
    weight = max(0.0, sigma**-2 - prior[1] ** -2) / drag**2
    pull = math.log(drag / prior[0]) / prior[1] ** 2 / drag + weight * drag
    said = pull * GRID - 0.5 * weight * GRID**2
    said = np.exp(said - said.max())
    each = [_believed(ball, kind) * said for kind in kinds]
    shares = np.sum(each, axis=0)
    shares /= shares.sum()
    mean = float(shares @ GRID)
    spread = math.sqrt(float(shares @ (GRID - mean) ** 2))
    # The error of a logarithm has the longer side of its number's.
    own = math.log1p(spread / mean) ** -2 - weight * mean**2
    if own < MOST_SPREAD**-2:
        likeliest = kinds[int(np.argmax([kind.sum() for kind in each]))]
        return _drag_of(ball, likeliest)
    return mean * math.exp(-(pull - weight * mean) * mean / own), own**-0.5


def _drag_of(ball: Ball, kind: Kind) -> tuple[float, float]:
    """Return the drag of balls of one kind, 1/m, and the spread of its logarithm."""
    drag, spread = replace(ball, density=kind.density).drag_per_m()
    return drag, math.hypot(spread, kind.spread)


def _believed(ball: Ball, kind: Kind) -> Floats:
    """Return how likely each drag of the grid is of balls of one kind."""
    drag, spread = _drag_of(ball, kind)
    likely = np.exp(-0.5 * (np.log(GRID / drag) / spread) ** 2)
    return np.asarray(kind.share * likely / spread + LEAST_SHARE)
