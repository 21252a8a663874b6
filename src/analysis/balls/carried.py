"""A ball that is seen and does not fly: it rolls, turns, or is carried. Its places are given."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from analysis.arrays import Floats
from analysis.balls.discs.disc import Disc
from analysis.balls.falling import OtherFall, falls_turned
from analysis.balls.films.film import Film, Picture
from analysis.balls.flight.known import Ball
from analysis.balls.gaps import period_of
from analysis.balls.seen.arcs import Sightings
from analysis.balls.seen.looks import Looks
from analysis.balls.seen.placing import Placed, Placer
from analysis.balls.seen.rim_shifts import place_turning
from analysis.balls.seen.windows import Motion, cut_windows
from analysis.errors import ShotRefusedError

LEAST_FRAMES = 6
NEAR_RADII = 1.0
"""By how much more a ball may have moved than its neighbours in time say."""


LEAST_MM, MOST_MM = 0.1, 2000.0
"""Diameters of balls that may be stated."""


class NotFlyingError(ShotRefusedError, ABC):
    """A film whose ball is seen and does not fly freely.

    Attributes
    ----------
    times_s
        Of all frames.
    placed
        Its places, once they are fitted; None before.
    """

    def __init__(self, reason: str, times_s: Floats) -> None:
        super().__init__("flight", reason)
        self.times_s = times_s
        self.placed: Placed | None = None

    @abstractmethod
    def place(self, film: Film) -> Placed | None:
        """Return the ball's places in the film that was refused; None where they cannot be told."""


class CarriedError(NotFlyingError):
    """A ball that rolls, or that a hand carries.

    Parameters
    ----------
    looks, seen
        Of the ball, and where something looks like it.

    Attributes
    ----------
    others
        Refusals of discs of other sizes in the same film.
    """

    def __init__(self, reason: str, looks: Looks, seen: Sightings) -> None:
        super().__init__(reason, seen.times_s)
        self._looks, self._seen = looks, seen
        self.others: tuple[CarriedError, ...] = ()

    def flies_turned(self, ball: Ball, quarter_turns: int) -> bool:
        """Return whether anything flies where the film's pictures are turned by quarter turns."""
        every = (self, *self.others)
        return any(falls_turned(one._seen, one._looks, ball, quarter_turns) for one in every)

    def place(self, film: Film) -> Placed | None:
        """Return the places of a ball that moves; None where it is seen in too few frames."""
        motion = _motion(self._seen, self._looks.radius_px)
        if len(motion.frames) < LEAST_FRAMES:
            return None
        placer = Placer.new(self._looks.radius_px, 0.0, patched=self._looks.patched)
        windows = cut_windows(film, self._looks, motion, 0.0)
        placer.learn_blur(windows, motion)
        return placer.place(windows, motion)


class OtherFallError(CarriedError):
    """A ball that bounces, and falls far otherwise than its diameter and the film's rate say.

    Parameters
    ----------
    fall
        How it falls.
    diameter_m
        That was stated.
    looks, seen
        Of the ball, and where something looks like it.
    per_frame
        Pictures for each frame of the file, whose rate it is that a person states.
    """

    def __init__(
        self,
        fall: OtherFall,
        diameter_m: float,
        looks: Looks,
        seen: Sightings,
        per_frame: float = 1.0,
    ) -> None:
        rate = 1.0 / period_of(seen.times_s) / per_frame
        millimetres = 1e3 * diameter_m
        frame, row, column = fall.first
        last, down, across = fall.last
        slow = fall.share < 1.0
        size = millimetres / fall.share
        or_size = f", or the diameter, about {_short(size)} mm (--ball-diameter-mm)"
        if not LEAST_MM <= size <= MOST_MM:
            or_size = ""
        why = "a film in slow motion has the player's, " if slow else ""
        super().__init__(
            f"the ball falls {_short(fall.share)} times as fast as one of {_short(millimetres)} mm "
            f"does at {_short(rate)} frames/s, from frame {frame} at ({row:.0f}, {column:.0f}) px "
            f"to frame {last} at ({down:.0f}, {across:.0f}) px: state the camera's rate, {why}"
            f"of about {_short(rate * fall.share**-0.5)} frames/s (--fps){or_size}",
            looks,
            seen,
        )
        self.fall = fall


def _short(value: float) -> str:
    """Return a number with three digits at least, and no power of ten."""
    return f"{value:.0f}" if value >= 100.0 else f"{value:.3g}"


class TurningError(NotFlyingError):
    """A ball that stays on its place and turns.

    Parameters
    ----------
    disc, ground
        Of the ball, in the middle picture of the film.
    """

    def __init__(self, disc: Disc, ground: Picture, times_s: Floats) -> None:
        place = f"at ({disc.row:.1f}, {disc.column:.1f}) px, {2 * disc.radius:.1f} px across"
        super().__init__(f"the ball does not fly: it turns on its place, {place}", times_s)
        self._disc, self._ground = disc, ground

    def place(self, film: Film) -> Placed | None:
        """Return its places in all frames; None where too little of its rim is seen."""
        return place_turning(film, self._disc, self._ground)


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
