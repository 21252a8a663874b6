"""How long a contact lasts, as a number of a table: from the flights after it.

Flights are those that leave at first touch, extrapolated; the bodies part where their surfaces do
on these. Hard spheres part at once.
"""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.collision.instant import parting_time
from analysis.collision.operator import Body
from analysis.model.predict.sides import NUMBERS, Flights, place_of_rate


def parting(sides: Flights, bodies: tuple[Body, Body], normal: Floats) -> tuple[Floats, Floats]:
    """Return durations, s, shape (S,), and their slopes by the 48 numbers, shape (S, 48).

    Parameters
    ----------
    normal
        From a to b at first touch, shape (S, 3): that of a plate stays.
    """
    gap = sides.place[:, 1, 1] - sides.place[:, 0, 1]
    opening = sides.velocity[:, 1, 1] - sides.velocity[:, 0, 1]
    reach = bodies[0].radius + bodies[1].radius
    if bodies[1].is_plate:
        along = (opening * normal).sum(axis=1)
        lasts = (reach - (gap * normal).sum(axis=1)) / along
        line = normal
    else:
        lasts = parting_time(gap, opening, np.full(len(gap), reach))
        # Paths that pass each other by say nothing better than the contact itself.
        lasts = np.where(np.isfinite(lasts), lasts, sides.duration)
        line = (gap + opening * lasts[:, None]) / reach
        along = (opening * line).sum(axis=1)
    slopes = np.zeros((len(gap), NUMBERS))
    for sphere, sign in ((0, 1.0), (1, -1.0)):
        rate = place_of_rate(sphere, spin=False, after=True)
        start = slice(rate.start - 3, rate.start)
        slopes[:, start] = sign * line / along[:, None]
        slopes[:, rate] = slopes[:, start] * lasts[:, None]
    return lasts, slopes
