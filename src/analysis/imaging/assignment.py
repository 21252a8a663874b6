"""Which outline is which sphere in which view, through all frames of a shot.

Discs are recognised once, in the frame that shows them best, and followed from there both ways:
a sphere may rise into the rows of the other view, so rows alone do not tell.
"""

from __future__ import annotations

import math

import numpy as np

from analysis.errors import ShotRefusedError
from analysis.imaging.discs import Disc, discs, peaks_near, vote
from analysis.imaging.frame import FilmEdges
from analysis.imaging.limb import LIMB_REACH_PX
from analysis.imaging.outlines import Outline, Place, fit_outlines, nothing_hidden
from analysis.imaging.tracks import Spheres, Track
from analysis.imaging.views import View, ViewGeometry

LEAST_RIM_SHARE = 0.2
CLEAR_RIM_SHARE = 0.4
"""Where every disc shows as much of its rim, and nothing else does, no better frame is sought."""
REACH = 0.35
"""A disc is looked for within this many radii of where its motion predicts it."""
CLOSE_PX = 1.5
"""So near to its place by two frames before is a disc in free flight; at the contact it is not."""
MOST_GROWTH = 0.15
"""An outline's radius differs from the expected one by less than this share."""
LEAST_COVERAGE = 0.4
KEEP_OFF_SIGMAS = 2.5


def seed_frame(
    film: FilmEdges, views: tuple[ViewGeometry, ...], radius_px: float
) -> tuple[int, dict[View, tuple[Disc, Disc]]]:
    """Find a frame that shows both spheres clearly in every view, or else the one that does best.

    Returns
    -------
    The frame's index, and for each view its two discs, the left one first.

    Raises
    ------
    ShotRefusedError
        No frame shows two spheres in each view.
    """
    best: tuple[float, int, dict[View, tuple[Disc, Disc]]] | None = None
    most_seen = (-1, 0, "")
    for k in _middle_first(len(film)):
        edges = film.whole(k)
        votes = vote(edges.points, radius_px, edges.shape)
        found = discs(votes, LEAST_RIM_SHARE, radius_px)
        pairs: dict[View, tuple[Disc, Disc]] = {}
        seen = 0
        for geometry in views:
            inside = [d for d in found if geometry.rows[0] <= d.row < geometry.rows[1]]
            seen += min(len(inside), 2)
            if len(inside) >= 2:
                left, right = sorted(inside[:2], key=lambda d: d.column)
                pairs[geometry.view] = (left, right)
        if seen > most_seen[0]:
            most_seen = (seen, k, ", ".join(f"({d.row:.0f}, {d.column:.0f})" for d in found))
        if len(pairs) < len(views) or not _columns_agree(pairs, radius_px):
            continue
        shares = [d.rim_share for pair in pairs.values() for d in pair]
        if best is None or sum(shares) > best[0]:
            best = (sum(shares), k, pairs)
        if len(found) == len(shares) and min(shares) >= CLEAR_RIM_SHARE:
            break
    if best is None:
        seen, k, places = most_seen
        raise ShotRefusedError(
            "assignment",
            f"no frame shows two spheres in each of {len(views)} views with the columns of the "
            f"views in agreement; the best frame shows {seen} of {2 * len(views)} discs of "
            f"radius {radius_px:.1f} px, at (row, column) {places or 'none'}",
            k,
        )
    return best[1], best[2]


def _middle_first(count: int) -> list[int]:
    """Return all indices below a number, the middle, the quarters, the eighths, and so on."""
    order: list[int] = []
    step = 1 << count.bit_length()
    while step > 1:
        order.extend(range(step // 2, count, step))
        step //= 2
    return [*order, *range(min(count, 1))]


def _columns_agree(pairs: dict[View, tuple[Disc, Disc]], radius_px: float) -> bool:
    columns = np.array([[disc.column for disc in pair] for pair in pairs.values()])
    return bool(np.ptp(columns, axis=0).max() < 0.5 * radius_px)


def follow(
    film: FilmEdges,
    views: tuple[ViewGeometry, ...],
    radius_px: float,
    *,
    least_coverage: float = LEAST_COVERAGE,
) -> Spheres:
    """Follow both spheres in all views through all frames.

    Edges are looked for only where a disc may be: where its motion predicts it, with the reach.

    Parameters
    ----------
    least_coverage
        Share of its limb that an outline shows, to be believed.

    Returns
    -------
    The tracks of sphere a (the one that comes from the left) and of sphere b.
    """
    seed, pairs = seed_frame(film, views, radius_px)
    spheres: Spheres = ({}, {})
    places: list[tuple[Track, tuple[float, float]]] = []
    for view, pair in pairs.items():
        for sphere, disc in zip(spheres, pair, strict=True):
            sphere[view] = Track(view)
            places.append((sphere[view], (disc.row, disc.column)))
    _look(film, seed, places, radius_px, least_coverage)
    tracks = [track for track, _ in places]
    for direction in (1, -1):
        k = seed + direction
        while 0 <= k < len(film):
            predicted = [(track, track.predict(k, direction)) for track in tracks]
            places = [(track, place) for track, place in predicted if place is not None]
            if places:
                _look(film, k, places, radius_px, least_coverage)
            k += direction
    first, second = (_first_column(sphere[View.FRONT]) for sphere in spheres)
    return spheres if first <= second else (spheres[1], spheres[0])


def _first_column(track: Track) -> float:
    return track.outlines[min(track.outlines)].circle.column if track.outlines else np.inf


def _look(
    film: FilmEdges,
    k: int,
    places: list[tuple[Track, tuple[float, float]]],
    radius_px: float,
    least_coverage: float,
) -> None:
    """Fit the outlines of a frame about the places, and keep those that hold.

    First closely about the places; where that does not find every disc, further around them and
    from the best peaks of the votes.
    """
    discs = np.array([(row, column, radius_px) for _, (row, column) in places])
    limits = KEEP_OFF_SIGMAS * film.settings.sigma_px, False
    for reach in (CLOSE_PX, REACH * radius_px):
        close = reach == CLOSE_PX
        points = film.about(k, discs + np.array([0.0, 0.0, reach + LIMB_REACH_PX + 1.0])).points
        if not close:
            edges = points.row, points.column, points.normal_row, points.normal_column
            peaks = peaks_near(edges, discs, reach)
            seen = peaks[:, 2] >= LEAST_RIM_SHARE / 2
            discs[seen, :2] = peaks[seen, :2]
        found = fit_outlines(points, discs, discs, nothing_hidden(len(discs)), limits)
        held = [
            outline is not None and _holds(outline, place, reach, least_coverage)
            for outline, place in zip(found, discs.tolist(), strict=True)
        ]
        if all(held):
            break
    for (track, _), outline, holds in zip(places, found, held, strict=True):
        if outline is not None and holds:
            track.outlines[k] = outline


def _holds(outline: Outline, place: Place, reach_px: float, least_coverage: float) -> bool:
    """Tell whether an outline shows enough of its limb, near its place and of its size."""
    circle, (row, column, radius) = outline.circle, place
    moved = math.hypot(circle.row - row, circle.column - column)
    grown = abs(circle.radius - radius)
    return outline.coverage >= least_coverage and moved < reach_px and grown < MOST_GROWTH * radius
