"""By how much e still depends on what a ball is taken to look like, once its flights are fitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from analysis.arrays import Floats
from analysis.balls.flight.fit import Fit, fit_flights
from analysis.balls.flight.flights import Flights, Observed, Start
from analysis.balls.flight.known import Known
from analysis.balls.seen.placing import Placed, Placer
from analysis.balls.seen.windows import Motion, Window
from analysis.balls.systematics import ByRadius, by_radius

LEAST_SIGMA = 0.3
"""Of the median stated error: no frame counts for more."""


def observed_of(
    placed: Placed, times_s: Floats, of_radius: ByRadius | None, *, sized: bool = True
) -> Observed:
    """Return places as flights are fitted to them; with None nothing of the radius is known.

    Parameters
    ----------
    sized
        Whether the ball's sizes count.
    """
    least = np.median(placed.sigmas, axis=0) if len(placed.frames) else 0.0
    sigmas = np.maximum(placed.sigmas, LEAST_SIGMA * least)
    plain = Observed(placed.frames, times_s[placed.frames], placed.places, sigmas)
    if of_radius is None:
        return replace(plain, bare=True)
    own = of_radius.of(placed.frames)
    # As if all had been fitted with one radius: what another does to places is in the flights' fit.
    places = placed.places - own.shifts * placed.larger[:, None]
    return replace(plain, places=places, leans=own.shifts, sizes=own.sizes if sized else None)


def flights_of(
    placer: Placer,
    seen: tuple[list[Window], Motion, float],
    placed: tuple[Placed, ByRadius | None],
    times_s: Floats,
    before: tuple[Start, Known, Flights | None],
) -> tuple[Observed, Flights | None]:
    """Return places, and the flights that are fitted to them.

    Before the ball's light is learned, sizes are crude as well, and do not count, unless bounces
    are lost without them: those of a ball that comes nearer sink in the picture of a camera that
    looks down.

    Parameters
    ----------
    seen
        Windows, where the ball is in them, and the time from row to row.
    placed
        Places, and what the radius does to them; None: the ball's light is not learned yet.
    before
        A first guess of the bounces, what is known of them, and the flights of an earlier pass.
    """
    (start, known, flights), (own, of_radius) = before, placed
    sized = not known.misled_by_sizes
    observed = observed_of(own, times_s, of_radius, sized=sized)
    fitted = fit_flights(observed, start, known, flights)
    bounces = 0 if fitted is None else fitted.bounces
    if of_radius is not None or not sized or bounces == len(start.times_s):
        return observed, fitted
    of_sizes = observed_of(own, times_s, by_radius(placer, seen, own))
    other = fit_flights(of_sizes, start, known)
    if other is None or other.bounces <= bounces:
        return observed, fitted
    return of_sizes, other


def last_change(coefficients: Sequence[Floats]) -> Floats:
    """Return by how much e of each bounce has changed when the ball's light was learned last."""
    if not coefficients:
        return np.zeros(0)
    alike = [each for each in coefficients if len(each) == len(coefficients[-1])]
    return np.asarray(np.abs(alike[-1] - alike[max(0, len(alike) - 2)]))


def by_outline(
    placer: Placer,
    seen: tuple[list[Window], Motion, float],
    fits: Sequence[Fit],
    times_s: Floats,
    exposure_sigma_s: float,
) -> Floats | None:
    """Return by how much e of each bounce depends on where the outline of a patched ball is.

    None can tell it where the ball is as light as its ground, nor where its smear ends there:
    places are fitted once more to a ball for which that is no chance, and with an exposure that is
    shorter by its error. None for other balls.

    Parameters
    ----------
    seen
        Windows, where the ball is in them, and the time from row to row.
    """
    if not placer.patched or not fits:
        return None
    observed, start, known, flights = fits[-1]
    e = flights.contacts[:, 3] / flights.contacts[:, 1]
    changed = np.zeros(len(e))
    shorter = max(0.0, placer.exposure_s - exposure_sigma_s)
    for other in (replace(placer, chance=0.0), replace(placer, exposure_s=shorter)):
        places = replace(observed_of(other.place(*seen), times_s, None), bare=observed.bare)
        fitted = fit_flights(places, start, known, flights)
        if fitted is not None and fitted.bounces == flights.bounces:
            changed = np.hypot(changed, fitted.contacts[:, 3] / fitted.contacts[:, 1] - e)
    return np.asarray(changed)


def by_sizes(fits: Sequence[Fit], of_radius: ByRadius | None) -> Floats | None:
    """Return by how much e of each bounce would change with sizes that may mislead.

    None where flights are fitted with sizes as they are, or none are known.
    """
    if not fits or of_radius is None:
        return None
    observed, start, known, flights = fits[-1]
    if not known.misled_by_sizes:
        return None
    sizes = of_radius.of(observed.frames).sizes
    sized = fit_flights(replace(observed, sizes=sizes), start, known, flights)
    if sized is None or sized.bounces != flights.bounces:
        return None
    e, other = (each.contacts[:, 3] / each.contacts[:, 1] for each in (flights, sized))
    return np.asarray(np.abs(e - other))
