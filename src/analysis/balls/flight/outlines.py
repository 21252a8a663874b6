"""How large a ball is seen on its way, and how round: it drifts, and a camera sees spheres aslant.

Away from the middle of the picture the outline of a sphere is an ellipse, longer towards the border
by half of the squared tangent of the angle to the line of sight.
"""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.balls.flight import path
from analysis.balls.flight.flights import Flights


def slants(flights: Flights, places: Floats) -> Floats:
    """Return squared tangents along rows and columns for a focal length of a larger side, (N, 2).

    Parameters
    ----------
    places
        px, shape (N, 2).
    """
    middle = flights.values[[path.MIDDLE_ROW, path.MIDDLE_COLUMN]]
    return np.asarray(((places - middle) / (2.0 * float(middle.max()))) ** 2)
