"""What is round and moves in a film, and where it may be in each frame.

None of it depends on the film's times: it is looked for once, however often flights are sought.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from analysis import threads
from analysis.arrays import Floats
from analysis.balls.discs.disc import Disc
from analysis.balls.films.fields import refuse_combed
from analysis.balls.films.film import Film, FilmHead, Picture, spread_frames
from analysis.balls.films.part import Cut, PartOfFilm
from analysis.balls.films.steady import refuse_shaken
from analysis.balls.seen.background import (
    Brightness,
    background,
    changes,
    evened,
    noise_of,
    some_pixels,
)
from analysis.balls.seen.looks import (
    LEAST_RADIUS_PX,
    LEAST_SHARE,
    MOST_SHARE,
    Looks,
    families,
    find_discs_that_move,
    looks_of,
    weight,
)
from analysis.balls.seen.quarter_turns import looks_turned, picture_turned, places_turned
from analysis.balls.seen.sighting import Sight
from analysis.balls.seen.surroundings import Surroundings
from analysis.balls.seen.turning import turning_ball
from analysis.errors import ShotRefusedError, counted

MOST_FAMILIES = 4
SURE_SHARE = 0.1
"""Of the surest family's weight: others are looked at only where no sure one flies."""
COARSE, LARGE_PICTURE = 4.0, 400_000
"""Times the smallest radius: smaller discs of larger pictures than this (px) are sought last."""
LEAST_FRAMES = 6


@dataclass(frozen=True, slots=True, eq=False)
class Sighted:
    """A ball, and where it may be in each frame.

    Attributes
    ----------
    looks
        Of the ball.
    places
        Of each frame row, column, response; arrays of shape (N, 3).
    about
        What is kept of the pictures about them; None of a film that is held.
    gains
        Light of each frame over that of what stands still, shape (frames,).
    """

    looks: Looks
    places: tuple[Floats, ...]
    about: Surroundings | None
    gains: Floats


class Looked:
    """A film that is looked through for balls.

    Parameters
    ----------
    film
        Of at least six frames.

    Attributes
    ----------
    film
        The same.
    samples, ground, noise
        Some frames by their numbers, as bright as one another; what stands still in them, shape
        (rows, columns, channels); and the noise of a pixel.
    shake_shown
        Whether it would be seen if the camera moved.
    turning
        A ball that only turns; None where there is none.

    Raises
    ------
    ShotRefusedError
        Too few frames; `InterlacedError` where two pictures are in one; `ShakenError` where the
        camera moves.
    """

    def __init__(self, film: Film) -> None:
        head = film.head
        if head.frames < LEAST_FRAMES:
            raise ShotRefusedError(
                "frames", f"{counted(head.frames, 'frame')}; {LEAST_FRAMES} are needed at least"
            )
        self.film = film
        self._read = film.chosen(spread_frames(head.frames, head.frame_bytes))
        self.samples, self.ground = _evened(self._read, head)
        self.noise = noise_of(list(self.samples.values()), self.ground)
        refuse_combed(self.samples, self.ground, self.noise)
        self.shake_shown = head.steady or refuse_shaken(self.samples)
        self._changed = changes(self.samples, self.ground, self.noise)
        self.turning = turning_ball(self._changed.values(), self.ground, radii_px(self.ground))
        self._discs: list[tuple[int, Disc]] = []
        self._sighted: list[list[Sighted]] = []

    def balls(self) -> Iterator[list[Sighted]]:
        """Give balls by ranges of sizes, one after another; what is found is remembered.

        Most of the work in a large picture is for the smallest discs: they are sought where larger
        ones do not fly.
        """
        for k, (radii, share) in enumerate(_size_ranges(self.ground)):
            if k == len(self._sighted):
                self._sighted.append(self._of_sizes(radii, share))
            yield self._sighted[k]

    def before(self, looks: Looks, ground: Picture) -> Sighted:
        """Return where a ball may be before another ground."""
        return _seen(self.film, [looks], self._read, ground)[0]

    def _of_sizes(self, radii: tuple[float, float], share: float) -> list[Sighted]:
        """Return balls of these radii, and larger ones that were too unsure before.

        Parameters
        ----------
        share
            Least weight of a family over the largest.
        """
        self._discs += find_discs_that_move(self.samples, self.ground, self._changed, radii)
        known = [one.looks.seen for some in self._sighted for one in some]
        groups = families(self._discs)[:MOST_FAMILIES]
        least = share * max(map(weight, groups), default=0.0)
        new = [each for each in groups if weight(each) >= least and tuple(each) not in known]
        head = self.film.head
        sought = [looks_of(each, self.samples, self.ground, head) for each in new]
        return _seen(self.film, sought, self._read, self.ground) if sought else []


class TurnedLook(Looked):
    """The same film turned by quarter turns: what was seen of it turns with it.

    Parameters
    ----------
    upright
        The film as it is.
    quarter_turns
        As `np.rot90` has them.
    """

    def __init__(self, upright: Looked, quarter_turns: int) -> None:
        self._upright, self._turns = upright, quarter_turns
        self._shape = upright.ground.shape[0], upright.ground.shape[1]
        self.film = PartOfFilm(upright.film, Cut(), quarter_turns)
        self.samples, self._read = (
            {number: np.rot90(picture, quarter_turns) for number, picture in each.items()}
            for each in (upright.samples, upright._read)
        )
        self.ground = picture_turned(upright.ground, quarter_turns)
        self.noise, self.shake_shown = upright.noise, upright.shake_shown
        # Of a ball that turns on its place no other film is asked.
        self.turning = None

    def balls(self) -> Iterator[list[Sighted]]:
        """Give the balls of the film as it is, turned."""
        for some in self._upright.balls():
            yield [self._turned(one) for one in some]

    def _turned(self, one: Sighted) -> Sighted:
        looks = looks_turned(one.looks, self._shape, self._turns)
        places = tuple(places_turned(each, self._shape, self._turns) for each in one.places)
        about = one.about and one.about.turned(self._read, self._shape, self._turns)
        return Sighted(looks, places, about, one.gains)


def _size_ranges(ground: Picture) -> list[tuple[tuple[float, float], float]]:
    """Return radii to search, and the least weight of a family over the largest."""
    low, high = radii_px(ground)
    middle = COARSE * low
    if ground.shape[0] * ground.shape[1] < LARGE_PICTURE or middle > high:
        return [((low, high), 0.0)]
    return [((middle, high), SURE_SHARE), ((low, middle), 0.0)]


def _evened(samples: dict[int, Picture], head: FilmHead) -> tuple[dict[int, Picture], Picture]:
    """Return frames as bright as one another, and what stands still in them."""
    some = {number: some_pixels(picture)[..., None] for number, picture in samples.items()}
    brightness = Brightness(background(list(some.values())), head)
    values = {number: brightness.of(picture)[0] for number, picture in some.items()}
    even = {number: evened(picture, values[number]) for number, picture in samples.items()}
    return even, background(list(even.values()))


def _seen(
    film: Film, sought: Sequence[Looks], samples: dict[int, Picture], ground: Picture
) -> list[Sighted]:
    """Return where each of some balls may be in each frame; the film is read once for all."""
    sights = [Sight(looks, ground) for looks in sought]
    brightness = Brightness(ground, film.head)
    places: list[list[Floats]] = [[] for _ in sought]
    gains: list[float] = []
    about = [
        None if film.may_be_held else Surroundings.new(looks.radius_px, samples) for looks in sought
    ]

    def looked_at(picture: Picture) -> tuple[Picture, float, list[Floats]]:
        values, gain = brightness.of(picture)
        return picture, gain, [sight.find(picture, values).places for sight in sights]

    for number, (picture, gain, seen) in enumerate(threads.each(looked_at, film.pictures())):
        gains.append(gain)
        for one, own, kept in zip(seen, places, about, strict=True):
            own.append(one)
            if kept is not None:
                kept.keep(number, picture, one)
    every = zip(sought, places, about, strict=True)
    return [Sighted(looks, tuple(own), kept, np.array(gains)) for looks, own, kept in every]


def radii_px(ground: Picture) -> tuple[float, float]:
    """Return the least and the largest radius of a ball in a picture of this size."""
    side = min(ground.shape[:2])
    return max(LEAST_RADIUS_PX, LEAST_SHARE * side), MOST_SHARE * side
