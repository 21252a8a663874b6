"""Balls that were found in a film, and which of several is the one that was asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.balls.gaps import Gap
from analysis.balls.seen.arcs import Chain
from analysis.balls.seen.free_fall import agreeing, as_stated
from analysis.balls.seen.looks import Looks, weight
from analysis.balls.seen.surroundings import Surroundings

CLEAR_FRAMES = 12
"""Of flights that bend alike and meet in a bounce: what flies in so many is the ball."""
MUCH_MORE = 1.25
"""Frames of flights that bend alike of less sure discs, over those of surer ones, that win."""
AS_SURE = 0.8
"""Weight of discs over that of others, of which neither are surer."""
APART_RADII = 2.0
"""Between two balls: a ball's own light and shadow, taken for discs of other sizes, lie nearer."""
HARDLY_SURE = 0.1
"""Weight of discs over that of others of one ball, whose size those are then."""
HALF_AS_STRONG = 0.5
"""Strength over that of the strongest chain, and frames over those of the ball that flies most
surely, of one that may be the ball whose size is stated."""


@dataclass(frozen=True, slots=True, eq=False)
class Search:
    """A ball and its flights as seen first.

    Attributes
    ----------
    looks, chain
        Of the ball.
    fall
        Free fall in the picture by the ball's size, (row, column) in px/s^2; where the flights bend
        otherwise, nearly as they do.
    contradicts
        Whether they do.
    times_s
        Of all frames, shape (frames,): as stated, but later where frames are missing before them.
    gaps
        Where a ball jumps along its flight by whole steps: frames that are missing.
    others
        Flights beside the ball's own, the strongest first, each with whether a disc is seen there.
    unexplained
        Frame, row and column where the ball is seen outside its flights; shape (N, 3).
    repeated
        Frames that show the picture before them once more.
    gains
        Light of each frame over that of what stands still, shape (frames,).
    about
        The pictures about all sightings; None of a film that is held.
    shake_shown
        Whether it would be seen if the camera moved.
    """

    looks: Looks
    chain: Chain
    fall: Floats
    others: tuple[tuple[Chain, bool], ...]
    unexplained: Floats
    repeated: tuple[int, ...]
    gains: Floats
    about: Surroundings | None
    contradicts: bool
    times_s: Floats
    gaps: tuple[Gap, ...]
    shake_shown: bool = True

    @property
    def as_stated(self) -> bool:
        """Return whether the ball surely bends as the stated diameter says."""
        return not self.contradicts and as_stated(self.chain, self.looks, self.fall)

    @property
    def bounces_as_stated(self) -> bool:
        """Return whether it clearly is the ball whose diameter is stated, and bounces."""
        bounces = len(self.chain.times_s) > 0 and frames_of(self) >= CLEAR_FRAMES
        return bounces and self.as_stated


def best_of(seen: Sequence[Search]) -> Search:
    """Return the ball that flies most surely; of several, the one whose diameter is stated.

    The surest rims come first; the strengths of families are each in units of its own.
    """
    best = seen[0]
    for one in seen[1:]:
        as_sure = weight(one.looks.seen) > AS_SURE * weight(best.looks.seen)
        enough = (1.0 if as_sure else MUCH_MORE) * frames_of(best)
        if frames_of(one) > enough and not _hardly_seen(one, best):
            best = one
    least = HALF_AS_STRONG * frames_of(best)
    others = [
        one for one in seen if one.as_stated and frames_of(one) > least and another(one, best)
    ]
    return best if best.as_stated or not others else max(others, key=frames_of)


def _hardly_seen(one: Search, best: Search) -> bool:
    """Return whether discs are far less sure than those of another size at the same ball.

    A ball with its shadow is a larger disc in a frame or two: its flights are the ball's own.
    """
    if weight(one.looks.seen) > HARDLY_SURE * weight(best.looks.seen):
        return False
    apart = _apart(one, best)
    return len(apart) >= CLEAR_FRAMES and bool(np.median(apart) < best.looks.radius_px)


def frames_of(found: Search) -> int:
    """Return in how many frames flights bend alike."""
    return agreeing(found.chain, found.looks, found.fall)[0]


def another(one: Search, best: Search) -> bool:
    """Return whether a second ball bounces elsewhere than the first, and clearly."""
    frames, alike = agreeing(one.chain, one.looks, one.fall)
    if one is best or frames < CLEAR_FRAMES or alike < 2 or one.contradicts:
        return False
    apart = _apart(one, best)
    reach = APART_RADII * max(one.looks.radius_px, best.looks.radius_px)
    return len(apart) >= CLEAR_FRAMES and bool(np.min(apart) > reach)


def _apart(one: Search, best: Search) -> list[float]:
    """Return how far two balls are from each other in the frames in which both fly, px."""
    theirs = {
        int(f): p for arc in best.chain.arcs for f, p in zip(arc.frames, arc.places, strict=True)
    }
    return [
        float(np.hypot(*(place - theirs[int(frame)])))
        for arc in one.chain.arcs
        for frame, place in zip(arc.frames, arc.places, strict=True)
        if int(frame) in theirs
    ]


def stated_first(linked: list[Chain], looks: Looks, fall: Floats) -> None:
    """Put the chain first that bends as the stated diameter says, where the strongest does not."""
    if as_stated(linked[0], looks, fall):
        return
    for k, chain in enumerate(linked[1:], start=1):
        sure = chain.strength > HALF_AS_STRONG * linked[0].strength
        if sure and len(chain.times_s) and as_stated(chain, looks, fall):
            linked.insert(0, linked.pop(k))
            return
