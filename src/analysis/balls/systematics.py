"""What the choices of a fit do to places and flights: radius, outline and light of the ball."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.flight.flights import Flights
from analysis.balls.flight.outlines import slants
from analysis.balls.seen.looks import CODEC_PX, Looks
from analysis.balls.seen.placing import Placed, Placer
from analysis.balls.seen.windows import Motion, Window

RADIUS_STEP = 0.003
"""Of the radius: places follow it in proportion so far."""
MOST_BY_RADIUS = 2.0
"""Of the radius's change: a place whose rim is seen on one side alone moves by about 1 of it."""
OUTLINE_SIGMA = 0.003
"""Relative, of a radius along the rows over that in other frames: what shading does to all alike
cancels, a codec's errors do not."""
ASLANT_SIGMA = 0.25
"""Of half the squared larger side over the focal length, where a film does not tell it."""
MOST_BY_LIGHT = 0.03
"""Of the radius: a smooth shading that is further off than that has lost the rim."""


def shifts(
    placer: Placer,
    seen: tuple[Sequence[Window], Motion, float],
    looks: Looks,
    bare: Placed,
    flights: Flights,
    *,
    compressed: bool,
) -> Floats:
    """Return by how much each place moves with the ball's radius, its outline and its light.

    A radius moves the rim's darker side less than the brighter one, and so does an outline that is
    longer towards the picture's border; a smooth shading alone takes part of a limb's fading for
    the rim. No scatter about flights tells what these do.

    Parameters
    ----------
    seen
        Windows, where the ball is in them, and the time from row to row.
    looks
        Of the ball: the radius is changed by its error.
    bare
        Places fitted before the film had taught the ball's light.
    compressed
        Whether a codec has been at the rims that tell the outline.

    Returns
    -------
    Of each cause and observed place, px; shape (3, N, 2).
    """
    placed = flights.observed
    radius, radius_sigma_px = placer.radius_px, looks.radius_sigma_px
    step = min(radius_sigma_px, RADIUS_STEP * radius)
    placer.radius_px = radius + step
    wide = placer.place(*seen)
    placer.radius_px = radius
    by_radius, by_light = (_moved(placed.frames, placed.places, each) for each in (wide, bare))
    by_radius = _at_most(by_radius / step, MOST_BY_RADIUS)
    slant = slants(flights, placed.places)
    rim = math.hypot(OUTLINE_SIGMA, CODEC_PX * compressed / radius)
    told = rim / max(float(slant.max()), 1e-12)
    by_outline = by_radius * radius * slant * min(told, ASLANT_SIGMA)
    return np.stack(
        [by_radius * radius_sigma_px, by_outline, _at_most(by_light, MOST_BY_LIGHT * radius)]
    )


def _at_most(moved: Floats, most: float) -> Floats:
    """Return shifts no longer than this: a fit that jumps says nothing of the others."""
    size = np.maximum(np.hypot(*moved.T), 1e-12)[:, None]
    return np.asarray(moved * np.minimum(1.0, most / size))


def _moved(frames: NDArray[np.intp], places: Floats, other: Placed) -> Floats:
    """Return another fit's places less these; those that it lacks have not moved."""
    _, own, theirs = np.intersect1d(frames, other.frames, return_indices=True)
    moved = np.zeros_like(places)
    moved[own] = other.places[theirs] - places[own]
    return moved


def with_shifts(flights: Flights, moved: Floats) -> Flights:
    """Return flights whose numbers are as uncertain as shifts of all places leave them, too.

    Parameters
    ----------
    moved
        Of each cause and observed place, px; shape (causes, N, 2).
    """
    steps = np.einsum("pna,cna->pc", flights.response, moved)
    return replace(flights, covariance=flights.covariance + steps @ steps.T)


def whole_sigmas(flights: Flights, moved: Floats) -> Floats:
    """Return standard errors of places: scatter about the flights and what moves all alike."""
    return np.asarray(np.sqrt(flights.scatter**2 + (moved**2).sum(axis=0)))


def apart_sigmas(flights: Flights, moved: Floats) -> Floats:
    """Return standard errors of places beside one another, without what moves all alike."""
    own = moved - np.median(moved, axis=1, keepdims=True)
    return np.asarray(np.sqrt(flights.scatter**2 + (own**2).sum(axis=0)))
