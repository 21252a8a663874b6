"""What of a chain of arcs a ball flies: it bends as a free fall does; no hand holds or catches it.

A ball that is let go stays where it was held for as long as a search with a wide tolerance likes:
frames of a hand bend a flight more slowly than gravity does. A rest at the top of a flight is found
only where places were fitted.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from analysis.arrays import Floats
from analysis.balls.seen.arcs import Arc, Chain, tolerance
from analysis.balls.seen.growing import LEAST_FRAMES
from analysis.balls.seen.looks import Looks

FALL_SHARE = (0.5, 2.0)
"""Of the fall that follows from the ball's size: between these a ball flies."""
STATED_SHARE = 0.15
"""Of the fall: by how much flights of the ball whose diameter is stated bend otherwise at most."""
BEND_SHARE, BEND_SIGMAS = 0.12, 2.0
"""Flights of one ball bend alike: up to what drag and perspective change, and errors of places."""
LEAST_BEND = 1.5
"""In errors of a place: how far a flight lies off its chord, where it says anything."""
SEEN_RADII, SEEN_PX = 0.03, 0.3
"""Error of a place as seen first."""
SURELY, FINEST = 12.0, 1 / 3
"""Evidence of a flight that is none by chance, and the least scatter that counts, in errors of a
place: sightings are rounded to pixels of their own."""
TOGETHER, KNOWN_BEND, IN_FLIGHT = 24.0, 0.1, 0.8
"""Evidence of short flights that are none by chance together; the error of a flight's bend, as a
share of it, up to which it is known; and the share of the frames from first to last, of flights and
of all, in which a ball that bounces is seen in flight."""
AT_BOUNCE, LEAST_CLEAR = 2, 12
"""Places next to a bounce, which may lie on its other side, and sightings of a flight that is long
enough to go without them."""
LEAST_E, MOST_E, STILL_RISES = 0.2, 1.1, 0.5
"""Speed after a bounce over that before it, and of that what is left at the end of a flight that is
cut while it rises."""
STEADY_RADII = 0.5
"""A ball that stays within so many radii for all its frames is not in flight."""


def agreeing(
    chain: Chain, looks: Looks, fall: Floats, most_unsure: float = math.inf
) -> tuple[int, int]:
    """Return how many frames and flights of a chain bend alike, as those of one ball do.

    What is no ball goes through pieces of falls too, each of which bends in its own way.

    Parameters
    ----------
    most_unsure
        Error of a flight's bend, as a share of it, from which on the flight does not count.
    """
    bends = [(arc, bend_of([arc], looks, fall)) for arc in chain.arcs]
    bent = [(arc, *bend) for arc, bend in bends if bend is not None]
    known = [each for each in bent if each[2] < most_unsure * abs(each[1])]
    most = 0, 0
    for _, middle, _ in known:
        alike = [
            arc
            for arc, bend, sigma in known
            if abs(bend - middle) < BEND_SHARE * middle + BEND_SIGMAS * sigma
        ]
        most = max(most, (len({int(frame) for arc in alike for frame in arc.frames}), len(alike)))
    return most


def falls(chain: Chain, looks: Looks, fall: Floats) -> bool:
    """Return whether a chain's flights bend as a fall does; one must be long enough to say.

    Anything that moves slowly goes through a few frames of some fall: a ball that rolls, or a hand.
    What hardly moves in any of its flights, as a leaf in the wind before a camera that shakes, does
    not fly. Nor does what goes through flights of a few sightings each, far off any one fall: by a
    wide tolerance so does all that moves in a film.
    """
    if all(_stays(arc, looks) for arc in chain.arcs):
        return False
    if not by_no_chance(chain, looks, fall):
        return False
    bend = bend_of(chain.arcs, looks, fall)
    if bend is None:
        return False
    (share, sigma), (low, high) = bend, FALL_SHARE
    return bool(low - 2 * sigma < share < high + 2 * sigma)


def by_no_chance(chain: Chain, looks: Looks, fall: Floats) -> bool:
    """Return whether one of a chain's flights surely is none by chance, or all together are none.

    A ball that bounces is in flight nearly all the time, and all its flights bend alike. Pieces of
    falls that a hand or clutter goes through have others between them, and bend in their own ways.
    """
    each = [_evidence(_clear(arc, looks.radius_px, fall), looks) for arc in chain.arcs]
    if max(each, default=0.0) >= SURELY:
        return True
    if sum(each) < TOGETHER:
        return False
    ends = [(int(arc.frames.min()), int(arc.frames.max()) + 1) for arc in chain.arcs]
    lasts = sum(end - begin for begin, end in ends)
    whole = max(end for _, end in ends) - min(begin for begin, _ in ends)
    seen = sum(len(arc.frames) for arc in chain.arcs)
    if seen < IN_FLIGHT * max(lasts, whole):
        return False
    return agreeing(chain, looks, fall, KNOWN_BEND)[1] == len(chain.arcs)


def _evidence(arc: Arc, looks: Looks) -> float:
    """Return the logarithm of how unlikely it is that a flight's sightings lie so by chance.

    Two sightings begin it. By chance each further one lies anywhere within the tolerance.
    """
    count = len(arc.frames)
    if count <= PARABOLA:
        return 0.0
    gone = arc.times_s - arc.times_s.mean()
    design = np.vander(gone / max(float(np.abs(gone).max()), 1e-9), PARABOLA)
    left = arc.places - design @ np.linalg.lstsq(design, arc.places, rcond=None)[0]
    scatter = float(np.sqrt((left**2).sum() / (2 * (count - PARABOLA))))
    finest = FINEST * (SEEN_RADII * looks.radius_px + SEEN_PX)
    return (count - 2) * math.log(tolerance(looks.radius_px) / max(scatter, finest))


def as_stated(chain: Chain, looks: Looks, fall: Floats) -> bool:
    """Return whether a chain's flights surely bend as the stated diameter says."""
    bend = bend_of(chain.arcs, looks, fall)
    return bend is not None and abs(bend[0] - 1.0) + bend[1] < STATED_SHARE


def bend_of(arcs: Sequence[Arc], looks: Looks, fall: Floats) -> tuple[float, float] | None:
    """Return the bend of flights as a share of the fall, and its error; None: all too short."""
    error = SEEN_RADII * looks.radius_px + SEEN_PX
    weight = bend = 0.0
    for arc in (_clear(each, looks.radius_px, fall) for each in arcs):
        if not _bends(arc, looks.radius_px, fall):
            continue
        gone = arc.times_s - arc.times_s.mean()
        straight = np.stack([np.ones_like(gone), gone], axis=1)
        curve = 0.5 * gone**2
        curve = curve - straight @ np.linalg.lstsq(straight, curve, rcond=None)[0]
        weight += float(curve @ curve)
        bend += float(curve @ arc.places[:, 0])
    if weight == 0.0:
        return None
    return bend / weight / float(fall[0]), error / float(np.sqrt(weight) * fall[0])


def shown_bend(lasts_s: float, radius_px: float, fall: Floats) -> tuple[float, float]:
    """Return how far a fall lies off its chord after a time, and how far is seen, px."""
    return float(fall[0]) * lasts_s**2 / 8, LEAST_BEND * (SEEN_RADII * radius_px + SEEN_PX)


def _bends(arc: Arc, radius_px: float, fall: Floats) -> bool:
    """Return whether a flight is long enough to bend by more than errors of places."""
    bend, least = shown_bend(float(arc.times_s[-1] - arc.times_s[0]), radius_px, fall)
    return bend >= least


def _clear(arc: Arc, radius_px: float, fall: Floats) -> Arc:
    """Return a flight without its ends, which a wide search follows over bounces, if it bends."""
    count = len(arc.frames)
    if count < LEAST_CLEAR:
        return arc
    inside = arc.part(AT_BOUNCE, count - AT_BOUNCE)
    return inside if _bends(inside, radius_px, fall) else arc


def flying(chain: Chain, looks: Looks, fall: Floats) -> Chain:
    """Return a chain from its first flight up to the one that does not bend as a fall does.

    Places of a ball that is held, rests or rolls go through pieces of short falls, and those meet
    in bounces. A last flight that is too short to bend counts while it rises from a bounce.
    """
    first, last = 0, len(chain.arcs)
    bends = [bend_of([arc], looks, fall) for arc in chain.arcs]
    still = [each is not None and each[0] + each[1] < FALL_SHARE[0] for each in bends]
    while first < last - 1 and still[first] and _stays(chain.arcs[first], looks):
        first += 1
    last = next((k for k in range(first + 1, last) if still[k]), last)
    while last > first + 1 and bends[last - 1] is None and not _rises(chain, last - 1, fall):
        last -= 1
    bounces = slice(first, last - 1)
    return Chain(chain.arcs[first:last], chain.times_s[bounces], chain.places[bounces])


def _rises(chain: Chain, index: int, fall: Floats) -> bool:
    """Return whether a flight rises from a bounce up to its end, as one that the film's end cuts.

    Its bounce says when and where it begins, and flights before how it falls.
    """
    before, after = chain.arcs[index - 1], chain.arcs[index]
    (came_at, _, came), (left_at, _, left) = (
        arc.course(fall, end=end) for arc, end in ((before, True), (after, False))
    )
    time = chain.times_s[index - 1]
    comes = float(came[0] + fall[0] * (time - came_at))
    leaves = -float(left[0] + fall[0] * (time - left_at))
    goes_on = leaves - float(fall[0]) * float(after.times_s[-1] - time)
    return LEAST_E * comes < leaves < MOST_E * comes and goes_on > STILL_RISES * leaves


def _stays(arc: Arc, looks: Looks) -> bool:
    """Return whether a ball hardly moves in an arc, as one that is held."""
    return float(np.ptp(arc.places, axis=0).max()) < STEADY_RADII * looks.radius_px


LEAST_KEPT = 2 * LEAST_FRAMES
MUCH_WIDER = 2.0
"""Scatter about one parabola over that of the sightings next to the bounce."""
SCATTER_RADII, SCATTER_PX = 0.02, 0.2
"""Scatter about a parabola that drag, and a ground that changes, may leave."""
PARABOLA, WITH_DRAG = 3, 5
"""Terms of a flight's rows: sightings show no drag, fitted places do."""
LEAST_RESTING = LEAST_FRAMES
FITTED_RADII, FITTED_PX = 5e-4, 0.005
"""Scatter of fitted places that their light may leave."""


def flown(chain: Chain, radius_px: float) -> Chain:
    """Return a chain without the frames in which the ball is held before it, or caught after it."""
    least = SCATTER_RADII * radius_px + SCATTER_PX
    arcs = list(chain.arcs)
    first, last = arcs[0], arcs[-1]
    arcs[0] = first.part(_of_arc(first, least), len(first.frames))
    last = arcs[-1]
    turned = replace(last, times_s=-last.times_s[::-1], places=last.places[::-1])
    arcs[-1] = last.part(0, len(last.frames) - _of_arc(turned, least))
    return replace(chain, arcs=tuple(arcs))


def _of_arc(arc: Arc, least: float) -> int:
    """Return how many sightings of an arc come before its flight."""
    first = _begins(arc.times_s, arc.places[:, 0], least)
    return 0 if first and _falls_alike(arc, first, least) else first


def _falls_alike(arc: Arc, first: int, least: float) -> bool:
    """Return whether the sightings before one fall as those from it on do.

    A light ball falls otherwise early than late, too.
    """
    if first <= PARABOLA:
        return False
    (early, sigma), (late, _) = (
        _fall(each.times_s, each.places[:, 0], least)
        for each in (arc.part(0, first), arc.part(first, len(arc.frames)))
    )
    low, high = FALL_SHARE
    return low * late + sigma < early < high * late - sigma


def _fall(times_s: Floats, rows: Floats, error: float) -> tuple[float, float]:
    """Return by how much rows bend, px/s^2, and the error of it."""
    gone = times_s - times_s.mean()
    design = np.stack([0.5 * gone**2, gone, np.ones_like(gone)], axis=1)
    inverse = np.linalg.pinv(design)
    return float(inverse[0] @ rows), error * float(np.hypot.reduce(inverse[0]))


def rests(times_s: Floats, rows: Floats, radius_px: float) -> int:
    """Return how many places of a first flight come before the ball is let go.

    Of the last flight turned round, the same says how many come after the ball is caught. Fewer
    than LEAST_RESTING are none: a ball that enters the picture is placed badly before its light is
    learned.

    Parameters
    ----------
    times_s, rows
        Of fitted places up to the first bounce, s and px, shape (N,).
    """
    least = FITTED_RADII * radius_px + FITTED_PX
    found = _begins(times_s[:-AT_BOUNCE], rows[:-AT_BOUNCE], least, WITH_DRAG)
    return found if found >= LEAST_RESTING else 0


def _begins(times_s: Floats, rows: Floats, least: float, terms: int = PARABOLA) -> int:
    """Return the first place from which one curve goes through all the rest.

    Its bend is free: drag and a scale that is not known yet change it.
    """
    low, high = 0, len(rows) - LEAST_KEPT
    if high <= 0:
        return 0

    def scatter(first: int) -> float:
        return _scatter(times_s[first:], rows[first:], terms)

    allowed = max(least, MUCH_WIDER * scatter(min(high, len(rows) // 2)))
    if scatter(0) < allowed or scatter(high) >= allowed:
        return 0
    while high - low > 1:
        middle = (low + high) // 2
        if scatter(middle) < allowed:
            high = middle
        else:
            low = middle
    return high


def _scatter(times_s: Floats, rows: Floats, terms: int) -> float:
    """Return the scatter of rows about a polynomial of so many terms, px."""
    gone = times_s - times_s[0]
    design = np.vander(gone / max(float(np.abs(gone[-1])), 1e-9), terms)
    left = rows - design @ np.linalg.lstsq(design, rows, rcond=None)[0]
    return float(np.sqrt((left**2).sum() / max(1, len(gone) - terms)))
