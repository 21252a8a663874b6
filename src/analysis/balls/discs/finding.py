"""All discs of one picture: spheres, coins, beads, on clutter, partly hidden, overlapping."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Singles
from analysis.balls.discs.alike import circles, shrunk
from analysis.balls.discs.candidates import RADIUS_STEP, candidates
from analysis.balls.discs.company import company
from analysis.balls.discs.disc import (
    LIKE_RADIUS,
    Disc,
    doubled,
    holds,
    on,
    one,
    same_rim,
    touch,
    within,
)
from analysis.balls.discs.evidence import HIDES, log_odds
from analysis.balls.discs.genuine import is_round, sharpness
from analysis.balls.discs.gradient import SIGMA_PX, Ground, evened, ground_of
from analysis.balls.discs.levels import SEARCH_RADIUS_PX, judged, levels_of, take
from analysis.balls.discs.rims import fit_rim

RIM_PX = 0.005
"""Error of any rim on a grid of pixels."""
NO_RIM_RADII = 0.1
"""Error of a disc, in its radii, whose rim the edges of the whole picture do not show."""
SURE = -6.0
"""log10 of the number of false alarms of a disc that is reported."""
DOUBTFUL = -2.0
NEARLY = 0.5
"""Of the best's log10 of false alarms: a circle about it that is as sure is the rim."""
SHARP, SHARPER, MOST_SHARPER = 1.3, 50.0, 0.02
"""Sharpness of a rim that says neither way, powers of ten by which a disc is surer for each 1 above
it, and how far above it counts."""
SOFTER = 0.07
"""By how much less sharp than theirs the rim of a disc like others may be."""
LEAST_ODDS, LEAST_CLUTTERED, LEAST_DOUBTFUL = -0.2, 0.4, -1.9
"""Least logarithm of the odds that a disc is a ball's, by all that is seen of it and of others like
it; of a picture with circles that are no balls, which has more of these; and where doubtful discs
are asked for."""


def find_balls(
    picture: NDArray[np.generic],
    radii_px: tuple[float, float],
    least: float = SURE,
    *,
    blotched: bool = True,
    sigma_px: float | None = None,
) -> list[Disc]:
    """Find all discs of a picture, the surest first.

    Parameters
    ----------
    picture
        Shape (rows, columns) or (rows, columns, channels), any depth.
    radii_px
        Smallest and largest radius.
    least
        log10 of the number of false alarms that is allowed.
    blotched
        Whether the picture shows a ground and paint, not changes alone: discs are sought too in it
        with blotches taken off by closing and opening, and a soft rim may be the ground's.
    sigma_px
        Width of the filter that finds edges; None: a narrow one.
    """
    sought = _Sought(radii_px, least, SIGMA_PX if sigma_px is None else sigma_px, blotched)
    values = np.ascontiguousarray(np.atleast_3d(picture), dtype=np.float32)
    if not blotched:
        return _of_versions(values, sought, (None,))
    return _of_versions(evened(values), sought, (None, cv2.MORPH_CLOSE, cv2.MORPH_OPEN))


@dataclass(frozen=True, slots=True)
class _Sought:
    """What `find_balls` is asked for: `least` is log10 of the false alarms allowed."""

    radii: tuple[float, float]
    least: float
    sigma_px: float
    blotched: bool


@dataclass(slots=True)
class _Candidate:
    """A circle of one version of the picture at one size, in the pixels of that version."""

    level: int
    disc: Disc


@dataclass(frozen=True, slots=True)
class _Found:
    """A circle as edges of one size of the picture show it, and fitted to those of the whole.

    `odds` is the logarithm of the odds that it is a ball's, by what is seen of itself.
    """

    disc: Disc
    refined: Disc
    odds: float = 0.0


def _of_versions(values: Singles, sought: _Sought, versions: tuple[int | None, ...]) -> list[Disc]:
    found: list[Disc] = []
    for disc in _with_rims(values, *_accepted(values, sought, versions), sought):
        # Two circles within one rim, or of a picture through what is no circle, may both be there.
        same = any(one(disc, other) for other in found)
        if not same and not (sought.blotched and any(doubled(disc, other) for other in found)):
            found.append(disc)
    return sorted(found, key=lambda disc: disc.log_alarms)


def _accepted(
    values: Singles, sought: _Sought, versions: tuple[int | None, ...]
) -> tuple[list[_Found], bool]:
    """Return circles that are discs, the surest first, each without the edges of those before it.

    A circle through what is no disc takes no edges away: those of a ball may be among them. Whether
    there are such circles comes second; rings and shadows are none.
    """
    radii = sought.radii
    least = sought.least + sought.blotched * SHARPER * MOST_SHARPER
    # A circle is tried at each row, column and radius of the range.
    radius_steps = max(1.0, math.log(radii[1] / radii[0]) / math.log(RADIUS_STEP))
    tests = math.log10(values.shape[0] * values.shape[1] * radius_steps * len(versions))
    levels = list(levels_of(values, radii, sought.sigma_px, versions))
    weights = [np.ones(len(level.gradient.edges), np.float32) for level in levels]
    waiting: list[_Candidate] = []
    for index, level in enumerate(levels):
        edges, shape = level.gradient.edges, level.gradient.field.shape[1:]
        places = candidates(edges, shape, level.radii, cluttered=sought.blotched)
        for place in places[:, 1:]:
            disc = judged(level, weights[index], place, tests)
            if disc is not None and disc.log_alarms < least - level.margin:
                waiting.append(_Candidate(index, disc))
    accepted: list[_Found] = []
    cluttered = False
    while waiting:
        waiting.sort(key=lambda each: each.disc.log_alarms, reverse=True)
        best = _outermost(waiting, waiting.pop()).disc
        if radii[0] * 0.97 <= best.radius <= radii[1] * 1.03:
            hiding = [each.disc for each in waiting if _may_hide(each.disc, best)]
            found = _disc_at(values, best, hiding, accepted, sought)
            if found is None or not _is_ball(values, found, accepted, cluttered, sought):
                cluttered |= found is not None and -math.inf < found.odds < LEAST_ODDS
                waiting = [each for each in waiting if not _less_sure(each.disc, best)]
                continue
            accepted.append(found)
        rest = []
        for level, own in zip(levels, weights, strict=True):
            take(level, own, best)
        for other in waiting:
            again: Disc | None = other.disc
            level = levels[other.level]
            if touch(other.disc, best):
                again = judged(level, weights[other.level], level.inward(other.disc), tests)
            if again is None or one(again, best):
                continue
            if again.log_alarms >= least - level.margin:
                continue
            rest.append(_Candidate(other.level, again))
        waiting = rest
    return accepted, cluttered


def _may_hide(disc: Disc, other: Disc) -> bool:
    return disc.log_alarms < HIDES and touch(disc, other) and not one(disc, other)


def _less_sure(disc: Disc, than: Disc) -> bool:
    return disc.log_alarms >= than.log_alarms and one(disc, than)


def _disc_at(
    values: Singles, disc: Disc, hiding: list[Disc], known: list[_Found], sought: _Sought
) -> _Found | None:
    """Return a circle fitted to its rim, if chance does not explain it, beside surer ones."""
    if not sought.blotched:
        return _Found(disc, at_rim(values, disc, sought.sigma_px))
    sharp = _with_sharpness(values, disc, sought)
    if sharp.log_alarms >= sought.least:
        return None
    refined = at_rim(values, sharp, sought.sigma_px)
    others = [each.refined for each in known] + hiding
    return _Found(sharp, refined, log_odds(values, refined, sought.sigma_px, others))


def _with_rims(
    values: Singles, accepted: list[_Found], cluttered: bool, sought: _Sought
) -> list[Disc]:
    """Return those of the circles that are rims, and discs like these."""
    discs = [each.disc for each in accepted]
    # The border of what is lit, or saturated, on a sphere is a circle too, next to its rim or not.
    rims = _rims([disc for disc in discs if not any(on(disc, other) for other in discs)])
    found = [each for each in accepted if any(each.disc is disc for disc in rims)]
    refined = [each.refined for each in found]
    return refined + _alike(values, sought, found, cluttered) if sought.blotched else refined


def _is_ball(
    values: Singles, found: _Found, known: list[_Found], cluttered: bool, sought: _Sought
) -> bool:
    if not sought.blotched:
        return True
    least = LEAST_CLUTTERED if cluttered else LEAST_ODDS
    least = LEAST_DOUBTFUL if sought.least > SURE else least
    odds = found.odds + company(found.refined, ((each.refined, each.odds) for each in known))
    return odds >= least and is_round(values, _place(found.refined), sought.sigma_px)


def _alike(values: Singles, sought: _Sought, known: list[_Found], cluttered: bool) -> list[Disc]:
    """Return discs like those found, which need neither votes nor edges where those show rims."""
    found = [each.refined for each in known]
    groups = _groups(found)
    # A circle is tried at each row and column, with three radii.
    tests = math.log10(values.shape[0] * values.shape[1] * 3 * max(1, len(groups)))
    more: list[Disc] = []
    grounds: dict[float, Ground] = {}
    for group in groups:
        own, others = (np.array([_place(each) for each in some]) for some in (group, found + more))
        factor = shrunk(own)
        if factor not in grounds:
            grounds[factor] = ground_of(values, factor)
        likely = [
            Disc(row, column, radius, *3 * (NO_RIM_RADII * radius,), rim, alarms)
            for row, column, radius, alarms, rim in circles(
                grounds[factor], own, others, tests
            ).tolist()
        ]
        crisp = float(np.median([_sharpness(values, disc, sought) for disc in group]))
        for disc in sorted(likely, key=lambda each: each.log_alarms):
            if any(
                one(disc, other) or within(disc, other) or within(other, disc)
                for other in (*found, *more)
            ):
                continue
            if _sharpness(values, disc, sought) < crisp - SOFTER:
                continue
            best = at_rim(values, disc, sought.sigma_px)
            if not same_rim(best, disc):
                continue
            odds = log_odds(values, best, sought.sigma_px, [*found, *more])
            if _is_ball(values, _Found(disc, best, odds), known, cluttered, sought):
                more.append(best)
    return more


def _groups(discs: list[Disc]) -> list[list[Disc]]:
    """Return discs of about one radius, group by group, the smallest first."""
    groups: list[list[Disc]] = []
    for disc in sorted(discs, key=lambda each: each.radius):
        if not groups or disc.radius > LIKE_RADIUS * groups[-1][0].radius:
            groups.append([])
        groups[-1].append(disc)
    return groups


def _place(disc: Disc) -> Floats:
    return np.array([disc.row, disc.column, disc.radius])


def _with_sharpness(values: Singles, disc: Disc, sought: _Sought) -> Disc:
    """Return a disc as sure as it is when its rim's sharpness counts as well, unless it is sure.

    Blotches of the ground are by chance as round as a faint or partly hidden ball, but as soft as
    all of the ground; a ball's limb is as sharp as the camera.
    """
    if disc.log_alarms < sought.least - SHARPER * (SHARP - 1.0):
        return disc
    surer = min(_sharpness(values, disc, sought) - SHARP, MOST_SHARPER)
    return replace(disc, log_alarms=disc.log_alarms - SHARPER * surer)


def _sharpness(values: Singles, disc: Disc, sought: _Sought) -> float:
    width = sought.sigma_px * max(1.0, disc.radius / (1.5 * SEARCH_RADIUS_PX))
    return sharpness(values, _place(disc), width)


def at_rim(values: Singles, disc: Disc, sigma_px: float) -> Disc:
    """Return a disc with its circle fitted to the edges of the whole picture, errors and all."""
    place = _place(disc)
    sigmas = np.array([disc.row_sigma, disc.column_sigma, disc.radius_sigma])
    found = fit_rim(values, place, sigma_px)
    if found is not None:
        place, sigmas = found
    else:
        sigmas = np.hypot(sigmas, NO_RIM_RADII * disc.radius)
    (row, column, radius), errors = place.tolist(), np.hypot(sigmas, RIM_PX).tolist()
    return replace(
        disc,
        row=row,
        column=column,
        radius=radius,
        row_sigma=errors[0],
        column_sigma=errors[1],
        radius_sigma=errors[2],
    )


def _outermost(waiting: list[_Candidate], best: _Candidate) -> _Candidate:
    """Return the surest circle about the best that is nearly as sure, and put the best back.

    Within a sphere's rim lies the border of its lit part, which has a side of the rim in common
    with it; a coin has an inner ring, a pool ball a number in a sharp ring.
    """
    about = [
        other
        for other in waiting
        if other.disc.log_alarms < NEARLY * best.disc.log_alarms and holds(other.disc, best.disc)
    ]
    if not about:
        return best
    chosen = about[-1]
    waiting.remove(chosen)
    waiting.append(best)
    return _outermost(waiting, chosen)


def _rims(discs: list[Disc]) -> list[Disc]:
    """Return the discs of circles within one another that are rims, from the outermost on."""
    kept: list[Disc] = []
    for disc in sorted(discs, key=lambda each: -each.radius):
        if not any(_no_rim(disc, other) for other in kept):
            kept = [*(other for other in kept if not _no_rim(other, disc)), disc]
    return [disc for disc in discs if any(disc is other for other in kept)]


def _no_rim(disc: Disc, other: Disc) -> bool:
    """Return whether of two circles, one within the other, this is the one that is no rim.

    Where a sphere of such a size would be wholly in front of another, it hides most of it. The
    outer one is the rim unless the inner one is far surer.
    """
    inner, outer = sorted((disc, other), key=lambda each: each.radius)
    rim = outer if outer.log_alarms < NEARLY * inner.log_alarms else inner
    return disc is not other and within(inner, outer) and disc is not rim
