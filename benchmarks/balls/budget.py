"""What the standard error of a bounce's e consists of, source by source.

With the fit's covariance C and e's slopes s the variance is s C s. C's inverse is the information
of the places plus 1 / sigma_k^2 for each number k that is known beforehand to sigma_k, so that with
w = C s the variance is what the scatter of places does, plus the sum of (w_k / sigma_k)^2.
"""

from __future__ import annotations

import math

import numpy as np

from analysis.balls.flight import path
from analysis.balls.flight.flights import Flights
from analysis.balls.flight.known import LEVEL_SIGMA

SOURCES = {
    "scale": (path.FALL,),
    "drag": (path.DRAG,),
    "rows' time": (path.ROW_TIME,),
    "line of sight": (path.PERSPECTIVE,),
    "focal length": (path.ASLANT,),
    "roll": (path.ROLL,),
    "lens": (path.BARREL,),
    "contact's time": (path.STAY, path.SHORTENING),
    "smear's light": (path.BIAS,),
    "radius": (path.OUTLINE,),
}
"""Numbers of the fit by what they are; those of no name are the drift away from the camera."""


def budget(flights: Flights, bounce: int, sigma: float) -> dict[str, float]:
    """Return standard errors of e by source, the largest first; their squares add up to e's.

    Parameters
    ----------
    sigma
        Of e, with what the fit does not tell.
    """
    slope = flights.slopes_of_e(bounce)
    moved = flights.covariance @ slope
    known = np.isfinite(flights.known_sigmas) & (flights.known_sigmas > 0)
    parts = np.zeros(len(moved))
    parts[known] = (moved[known] / flights.known_sigmas[known]) ** 2
    found = {name: math.sqrt(parts[list(own)].sum()) for name, own in SOURCES.items()}
    named = [index for own in SOURCES.values() for index in own]
    found["drift"] = math.hypot(*np.sqrt(np.delete(parts, named)), *(flights.drifts @ moved))
    found["level"] = abs(float(moved[path.LEVEL].sum())) / LEVEL_SIGMA
    fitted = float(slope @ moved)
    found["places"] = _root(fitted - _square(found))
    found["rise of the drift"] = abs(float(slope @ flights.by_rise))
    found["ball's light and codec"] = _root(sigma**2 - fitted - found["rise of the drift"] ** 2)
    return dict(sorted(found.items(), key=lambda each: -each[1]))


def _square(parts: dict[str, float]) -> float:
    return sum(part**2 for part in parts.values())


def _root(square: float) -> float:
    return math.sqrt(max(0.0, square))
