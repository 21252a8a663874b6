"""The channel in which a ball's places lie nearest to free flights.

Codecs spoil colours, shadows and reflections brightness, and which is worse differs from film to
film: two grounds, a saturated ball, a wall of the ball's own colour. Flights tell it, as places of
one ball in all channels lie on the same ones.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from analysis.balls.flight.fit import fit_flights
from analysis.balls.flight.flights import Flights, Ints, Observed, Start
from analysis.balls.flight.known import Known
from analysis.balls.seen.looks import Looks
from analysis.balls.seen.placing import Placed, Placer
from analysis.balls.seen.windows import Cuts, Motion, Window

FAR_RADII = 0.1
"""A place that lies farther off flights, or in none, counts as one that lies so far."""
CLEARER = 0.95
"""Distance from flights, over that of the ball's own channel, of one that is taken in its place."""


@dataclass(frozen=True, slots=True, eq=False)
class Channel:
    """A ball in one channel: its looks, its windows, and its places before any light is learned."""

    looks: Looks
    windows: list[Window]
    placed: Placed


def clearest(
    placer: Placer,
    own: Channel,
    seen: tuple[Cuts, Motion],
    fitting: tuple[Callable[[Placed], Observed], Start, Known],
) -> Channel:
    """Return the channel in which places lie nearest to free flights: its own if none is clearer.

    The placer has that channel's blur afterwards.

    Parameters
    ----------
    own
        The channel in which the ball was placed.
    seen
        Its surroundings, and where it is expected in them.
    fitting
        What makes observations of places, and what flights are fitted with.
    """
    observe, start, known = fitting
    cuts, motion = seen
    fitted = fit_flights(observe(own.placed), start, known) if own.looks.others else None
    if fitted is None:
        return own
    frames, best, blur = own.placed.frames, own, placer.blur_px
    least = CLEARER * _off(fitted, frames, own.looks)
    for weights in own.looks.others:
        looks = replace(own.looks, light_weights=weights)
        windows = cuts.windows(looks)
        placer.learn_blur(windows, motion)
        placed = placer.place(windows, motion)
        placed = placed.of(np.isin(placed.frames, frames))
        flights = fit_flights(observe(placed), start, known, fitted)
        off = np.inf if flights is None else _off(flights, frames, looks)
        if off < least:
            best, least, blur = Channel(looks, windows, placed), off, placer.blur_px
    placer.blur_px = blur
    return best


def _off(flights: Flights, frames: Ints, looks: Looks) -> float:
    """Return the root mean square distance of places from flights, px; far ones count less."""
    most = FAR_RADII * looks.radius_px
    off = np.full(len(frames), most)
    own = np.isin(frames, flights.observed.frames)
    off[own] = np.minimum(np.hypot(*flights.residuals.T), most)
    return float(np.sqrt((off**2).mean()))
