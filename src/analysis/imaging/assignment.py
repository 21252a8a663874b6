"""Which outline is which sphere in which view, through all frames of a shot.

Discs are recognised once, in the frame that shows them best, and followed from there both ways:
a sphere may rise into the rows of the other view, so rows alone do not tell.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.errors import ShotRefusedError
from analysis.imaging.discs import Disc, discs, nearest_peak, vote
from analysis.imaging.frame import FrameEdges
from analysis.imaging.outlines import Place, fit_outline
from analysis.imaging.tracks import Spheres, Track
from analysis.imaging.views import View, ViewGeometry

LEAST_RIM_SHARE = 0.2
REACH = 0.35
"""A disc is looked for within this many radii of where its motion predicts it."""
LEAST_COVERAGE = 0.4
KEEP_OFF_SIGMAS = 2.5


def seed_frame(
    votes: Sequence[NDArray[np.float32]], views: tuple[ViewGeometry, ...], radius_px: float
) -> tuple[int, dict[View, tuple[Disc, Disc]]]:
    """Find the frame that shows both spheres best in every view.

    Parameters
    ----------
    votes
        Of each frame (`discs.vote`).

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
    for k, own in enumerate(votes):
        found = discs(own, LEAST_RIM_SHARE, radius_px)
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
        score = sum(d.rim_share for pair in pairs.values() for d in pair)
        if best is None or score > best[0]:
            best = (score, k, pairs)
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


def _columns_agree(pairs: dict[View, tuple[Disc, Disc]], radius_px: float) -> bool:
    columns = np.array([[disc.column for disc in pair] for pair in pairs.values()])
    return bool(np.ptp(columns, axis=0).max() < 0.5 * radius_px)


def follow(
    frames: Sequence[FrameEdges],
    views: tuple[ViewGeometry, ...],
    radius_px: float,
    sigma_px: float,
    *,
    least_coverage: float = LEAST_COVERAGE,
) -> Spheres:
    """Follow both spheres in all views through all frames.

    Parameters
    ----------
    least_coverage
        Share of its limb that an outline shows, to be believed.

    Returns
    -------
    The tracks of sphere a (the one that comes from the left) and of sphere b.
    """
    votes = [vote(frame.points, radius_px, frame.shape) for frame in frames]
    seed, pairs = seed_frame(votes, views, radius_px)
    keep_off = KEEP_OFF_SIGMAS * sigma_px
    spheres: Spheres = ({}, {})
    places: list[tuple[Track, Place]] = []
    for view, pair in pairs.items():
        for sphere, disc in zip(spheres, pair, strict=True):
            sphere[view] = Track(view)
            places.append((sphere[view], (disc.row, disc.column, radius_px)))
    kept = keep_off, least_coverage
    _fit_all(frames[seed], seed, places, kept)
    for direction in (1, -1):
        k = seed + direction
        while 0 <= k < len(frames):
            places = _expected(votes[k], k, direction, spheres, radius_px)
            _fit_all(frames[k], k, places, kept)
            k += direction
    first, second = (_first_column(sphere[View.FRONT]) for sphere in spheres)
    return spheres if first <= second else (spheres[1], spheres[0])


def _first_column(track: Track) -> float:
    return track.outlines[min(track.outlines)].circle.column if track.outlines else np.inf


def _expected(
    votes: NDArray[np.float32], k: int, direction: int, spheres: Spheres, radius_px: float
) -> list[tuple[Track, Place]]:
    """Return where each track's disc should be: the best peak near its prediction, or that."""
    places: list[tuple[Track, Place]] = []
    for track in (track for sphere in spheres for track in sphere.values()):
        predicted = track.predict(k, direction)
        if predicted is None:
            continue
        peak = nearest_peak(votes, *predicted, REACH * radius_px)
        if peak is not None and peak.rim_share >= LEAST_RIM_SHARE / 2:
            predicted = (peak.row, peak.column)
        places.append((track, (*predicted, radius_px)))
    return places


def _fit_all(
    frame: FrameEdges, k: int, places: list[tuple[Track, Place]], limits: tuple[float, float]
) -> None:
    """Fit the outlines of a frame and keep those that hold.

    Parameters
    ----------
    limits
        Distance to keep off other discs, pixels, and the least coverage.
    """
    keep_off_px, least_coverage = limits
    for track, place in places:
        others = [other for t, other in places if t is not track]
        outline = fit_outline(frame.points, place, others, keep_off_px)
        if outline is None or outline.coverage < least_coverage:
            continue
        row, column, radius = place
        moved = np.hypot(outline.circle.row - row, outline.circle.column - column)
        if moved < REACH * radius and abs(outline.circle.radius - radius) < 0.15 * radius:
            track.outlines[k] = outline
