"""Finding the ball of a film: what is round, moves, and falls as things fall."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from analysis.arrays import Floats
from analysis.balls.carried import CarriedError, OtherFallError, TurningError
from analysis.balls.discs.disc import Disc
from analysis.balls.discs.finding import find_balls
from analysis.balls.falling import flights_of, other_fall, stated_fall, without_jumps
from analysis.balls.films.film import Picture
from analysis.balls.flight.known import Ball
from analysis.balls.found import APART_RADII, MUCH_MORE, Search, another, best_of, frames_of
from analysis.balls.gaps import Gap
from analysis.balls.looking import Looked, Sighted, radii_px
from analysis.balls.seen.arcs import Chain, Sightings
from analysis.balls.seen.background import background, changes, noise_of
from analysis.balls.seen.ends import lengthened
from analysis.balls.seen.free_fall import STEADY_RADII, shown_bend
from analysis.balls.seen.left_out import refuse_thinned
from analysis.balls.seen.looks import Looks, families, find_discs_that_move, looks_of
from analysis.balls.seen.repeats import refuse_brought_to_rate, repeated
from analysis.balls.seen.uncovered import uncovered
from analysis.errors import ShotRefusedError

LEAST_BALL_FRAMES = 6
ON_A_LINE, MOST_OF = 0.1, 0.75
"""Of the way that a ball goes, and of its places: what rolls or slides keeps to a line."""
NEAR_RADII = 0.5
"""From a flight to a disc that is the same thing."""
AS_STRONG, HARDLY_SEEN = 0.7, 0.4
"""Of a response: what is seen while the ball flies elsewhere and is the same thing; of the ball's
mean response in its flights: what is none."""


def search(looked: Looked, times_s: Floats, ball: Ball, *, complete: bool = False) -> Search:
    """Find the ball whose flights explain most.

    Parameters
    ----------
    looked
        The film.
    times_s
        Of the frames.
    complete
        Whether no frame is taken to be missing.

    Raises
    ------
    ShotRefusedError
        Nothing round that moves, or nothing of it flies freely; `TurningError` of a ball that only
        turns; `BroughtToRateError` where pictures are repeated in a rhythm; `ThinnedError` where
        they are left out in one.
    """
    ground = looked.ground
    if looked.turning is not None:
        raise TurningError(looked.turning, ground, times_s)
    seen: list[Search] = []
    carried: list[CarriedError] = []
    otherwise: OtherFallError | None = None
    best: Search | None = None
    for balls in looked.balls():
        for one in _searches(looked, times_s, ball, balls, complete=complete):
            if isinstance(one, OtherFallError):
                otherwise = max(otherwise or one, one, key=lambda each: each.fall.frames)
                continue
            if isinstance(one, CarriedError):
                carried.append(one)
                continue
            seen.append(one)
        best = best_of(seen) if seen else None
        if best is not None and best.bounces_as_stated:
            break
    if otherwise is not None and (
        best is None or otherwise.fall.frames > MUCH_MORE * frames_of(best)
    ):
        raise otherwise
    if best is not None:
        others = tuple((one.chain, True) for one in seen if another(one, best))
        best = _uncovered(best, looked, (times_s, ball), complete=complete)
        return replace(best, others=(*best.others, *others), shake_shown=looked.shake_shown)
    if carried:
        carried[0].others = tuple(carried[1:])
        raise carried[0]
    raise ShotRefusedError(
        "ball",
        f"nothing round moves in this film: {len(looked.samples)} of its "
        f"{looked.film.head.frames} frames were looked at{_at_rest(ground)}; check that the ball "
        "is in the picture and the camera stands still",
    )


def _uncovered(
    best: Search, looked: Looked, asked: tuple[Floats, Ball], *, complete: bool
) -> Search:
    """Return a ball's flights once more, where it hid what stands still in most of the frames."""
    samples, ground = looked.samples, looked.ground
    about = best.looks.radius_px, best.chain, best.unexplained
    bare = uncovered(samples, ground, looked.noise, about)
    if bare is None:
        return best
    looks = looks_of(best.looks.seen, samples, bare, looked.film.head)
    balls = [looked.before(looks, bare)]
    (again,) = _searches(looked, *asked, balls, complete=complete)
    if not isinstance(again, Search) or len(again.chain.times_s) < len(best.chain.times_s):
        return best
    return replace(again, others=best.others)


def _searches(
    looked: Looked, times_s: Floats, ball: Ball, balls: Sequence[Sighted], *, complete: bool
) -> Iterator[Search | CarriedError]:
    """Give the flights of each of some balls, or why it has none."""
    head = looked.film.head
    for one in balls:
        looks, places = one.looks, list(one.places)
        refuse_brought_to_rate(places, times_s)
        refuse_thinned(places, times_s)
        twice = repeated(places)
        for frame in twice:
            places[frame] = places[frame][:0]
        seen = Sightings(times_s, places, (head.height, head.width))
        stated = stated_fall(ball, looks)
        gaps: tuple[Gap, ...] = ()
        flights = flights_of(seen, looks, stated)
        if not complete:
            seen, gaps, flights = without_jumps(seen, looks, stated, flights)
        other = other_fall(seen, looks, stated, flights)
        if other is not None:
            yield OtherFallError(other, ball.diameter_m, looks, seen, head.per_frame)
            continue
        if flights is None:
            said = f"{cause_of(seen, looks, stated)}; no flight of four frames is in this film"
            yield CarriedError(said, looks, seen)
            continue
        linked, chain, fall = flights
        chain = lengthened(chain, seen, looks.radius_px, fall)
        others = tuple((c, _round(c, looks)) for c in linked[1:] if _beside(c, chain))
        beyond = _unexplained(seen, linked, chain, looks.radius_px)
        odd = bool(fall[0] != stated[0])
        known = seen.times_s, gaps
        light = one.gains, one.about
        yield Search(looks, chain, fall, others, beyond, twice, *light, odd, *known)


def _at_rest(ground: Picture) -> str:
    """Say what is round and stands still: a ball that rests or only turns."""
    still = find_balls(ground, radii_px(ground))
    if not still:
        return ""
    first = still[0]
    place = f"at ({first.row:.1f}, {first.column:.1f}) px, {2 * first.radius:.1f} px across"
    others = f" and {len(still) - 1} more" if len(still) > 1 else ""
    return f"; what is round and rests or turns on its place: {place}{others}"


def _beside(other: Chain, chain: Chain) -> bool:
    """Return whether another chain lasts beside the ball's own."""
    own = {int(f) for arc in chain.arcs for f in arc.frames}
    theirs = {int(f) for arc in other.arcs for f in arc.frames}
    return len(own & theirs) >= LEAST_BALL_FRAMES


def _round(chain: Chain, looks: Looks) -> bool:
    """Return whether a disc of the ball's radius was found where a chain goes."""
    near = NEAR_RADII * looks.radius_px
    return any(
        np.hypot(disc.row - row, disc.column - column) < near
        for arc in chain.arcs
        for frame, (row, column) in zip(arc.frames.tolist(), arc.places, strict=True)
        for own, disc in looks.seen
        if own == frame
    )


def _unexplained(
    seen: Sightings, linked: Sequence[Chain], chain: Chain, radius_px: float
) -> Floats:
    """Return frame and place where the ball is seen, strongest, outside all flights that fall.

    What is seen at a place while the ball flies elsewhere is none, and what hardly looks like it.
    """
    in_flight = {int(f) for each in linked[1:] for arc in each.arcs for f in arc.frames}
    in_flight |= {int(f) for arc in chain.arcs for f in arc.frames}
    still = _beside_flights(seen, chain, radius_px)
    least = HARDLY_SEEN * chain.strength / sum(len(arc.frames) for arc in chain.arcs)
    found = []
    for k, places in enumerate(seen.places):
        if k in in_flight:
            continue
        for place in places[places[:, 2] > least]:
            near = np.hypot(*(still[:, :2] - place[:2]).T) < NEAR_RADII * radius_px
            alike = still[near, 2] > AS_STRONG * place[2]
            if alike.sum() < LEAST_BALL_FRAMES:
                found.append((k, *place[:2]))
                break
    return np.array(found, dtype=np.float64).reshape(-1, 3)


def _beside_flights(seen: Sightings, chain: Chain, radius_px: float) -> Floats:
    """Return row, column and response of what is seen while the ball flies elsewhere."""
    beside = [
        each
        for arc in chain.arcs
        for frame, own in zip(arc.frames.tolist(), arc.places, strict=True)
        for each in seen.places[frame]
        if np.hypot(*(each[:2] - own)) > APART_RADII * radius_px
    ]
    return np.array(beside, dtype=np.float64).reshape(-1, 3)


def cause_of(seen: Sightings, looks: Looks, fall: Floats) -> str:
    """Say how something moves that does not fly."""
    frames = [k for k, places in enumerate(seen.places) if len(places)]
    if len(frames) < LEAST_BALL_FRAMES:
        return f"a ball is seen in {len(frames)} frames only"
    surest = np.array([seen.places[k][0, :2] for k in frames])
    first, last = surest[0], surest[-1]
    place = f"from ({first[0]:.0f}, {first[1]:.0f}) to ({last[0]:.0f}, {last[1]:.0f}) px"
    down, across = abs(last[0] - first[0]), abs(last[1] - first[1])
    span = f"frame {frames[0]} to {frames[-1]}, {place}; check frame rate and diameter if it flies"
    along = across > 2 * down and across > STEADY_RADII * looks.radius_px
    if along and _off_a_line(surest) < max(ON_A_LINE * across, NEAR_RADII * looks.radius_px):
        return f"the ball rolls or slides: {span}"
    lasts_s = float(seen.times_s[frames[-1]] - seen.times_s[frames[0]])
    bend, least = shown_bend(lasts_s, looks.radius_px, fall)
    if bend < least:
        return (
            f"the ball is seen for too short a time to tell whether it flies ({1e3 * lasts_s:.3g} "
            f"ms, in which a fall bends by {bend:.2f} px; from {least:.2f} px on that is seen): "
            f"{span}"
        )
    return f"the ball does not fall freely, as if it were held or carried: {span}"


def _off_a_line(places: Floats) -> float:
    """Return how far most of some places lie at most from the line from the first to the last."""
    way = places[-1] - places[0]
    off = (places - places[0]) @ np.array([-way[1], way[0]]) / np.hypot(*way)
    return float(np.quantile(np.abs(off), MOST_OF))


def rings(pictures: Mapping[int, Picture]) -> dict[int, Disc]:
    """Return the surest disc of the size that is seen most surely, by frame.

    Parameters
    ----------
    pictures
        Some frames of a film, shape (rows, columns, channels), with their numbers. What differs
        from what most of them show is looked at; a frame without such a disc is left out.
    """
    samples = dict(pictures)
    ground = background(list(samples.values()))
    noise = noise_of(list(samples.values()), ground)
    apart = changes(samples, ground, noise)
    sizes = families(find_discs_that_move(samples, ground, apart, radii_px(ground)))
    if not sizes:
        return {}
    # Of each frame the surest disc comes first.
    return dict(reversed(sizes[0]))
