"""A ball that is seen and does not fly: it rolls, or a hand carries it. Its places are given."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.balls.films.film import Film
from analysis.balls.seen.arcs import Sightings
from analysis.balls.seen.looks import Looks
from analysis.balls.seen.placing import Motion, Placed, Placer, cut_windows
from analysis.errors import ShotRefusedError

Floats = NDArray[np.float64]

LEAST_FRAMES = 6
NEAR_RADII = 1.0
"""By how much more a ball may have moved than its neighbours in time say."""


class NotFlyingError(ShotRefusedError):
    """A film whose ball is seen and does not fly freely.

    Attributes
    ----------
    looks, seen
        Of the ball, and where something looks like it.
    placed
        Its places, once they are fitted; None before.
    """

    def __init__(self, reason: str, looks: Looks, seen: Sightings) -> None:
        super().__init__("flight", reason)
        self.looks, self.seen = looks, seen
        self.placed: Placed | None = None


def place_carried(film: Film, refused: NotFlyingError) -> Placed | None:
    """Fit the places of a ball that does not fly; None where it is seen in too few frames."""
    motion = _motion(refused.seen, refused.looks.radius_px)
    if len(motion.frames) < LEAST_FRAMES:
        return None
    placer = Placer.new(refused.looks.radius_px, 0.0)
    windows = cut_windows(film, refused.looks, motion, 0.0)
    placer.learn_blur(windows, motion)
    return placer.place(windows, motion)


def _motion(seen: Sightings, radius_px: float) -> Motion:
    """Return the strongest sighting of each frame that lies on the way of its neighbours."""
    frames = np.array([k for k, places in enumerate(seen.places) if len(places)], dtype=np.intp)
    if len(frames) < LEAST_FRAMES:
        return Motion(frames, np.zeros((len(frames), 2)), np.zeros((len(frames), 2)))
    places = np.array([seen.places[k][0, :2] for k in frames])
    middle = places.copy()
    middle[1:-1] = np.median([places[:-2], places[1:-1], places[2:]], axis=0)
    smooth = np.hypot(*(places - middle).T) < NEAR_RADII * radius_px
    frames, places = frames[smooth], places[smooth]
    if len(frames) < LEAST_FRAMES:
        return Motion(frames, places, np.zeros_like(places))
    speeds = np.gradient(places, seen.times_s[frames], axis=0)
    return Motion(frames, places, speeds)
