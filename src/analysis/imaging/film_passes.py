"""What is done in every frame of a film once its discs are followed, in one compiled pass each."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Singles
from analysis.compiled import compiled, part
from analysis.imaging.edge.windows import Filters, edges_about
from analysis.imaging.film_following import FilmCurves, Outlines, keep
from analysis.imaging.limb import LIMB_REACH_PX, settle_outlines
from analysis.imaging.marker.marker_curves import LEAST_POINTS, dark_ellipses

Indices = NDArray[np.intp]


@part
def shown(coverage: Floats, k: int, own: Indices) -> int:
    """Fill which discs a frame shows; return how many."""
    count = 0
    for d in range(coverage.shape[0]):
        if coverage[d, k] >= 0.0:
            own[count] = d
            count += 1
    return count


@compiled
def refit_discs(
    curves: FilmCurves,
    seen: tuple[Floats, Floats],
    radii: Floats,
    hidden: tuple[Floats, Floats],
    limits: tuple[float, bool],
) -> Outlines:
    """Fit every outline of a film again with its radius held.

    Parameters
    ----------
    seen
        Circles and coverages so far, shape (discs, frames, 3) and (discs, frames).
    radii
        Shape (discs,).
    hidden
        Where markers may hide the limb of each disc in each frame, shape (discs, frames, markers,
        2), and the cosine of the angle about them, shape (discs,), as `limb.Hidden`.
    limits
        Distance to keep off other discs, pixels, and that radii are held.
    """
    discs, film = seen[1].shape
    circles, covariance = np.zeros((discs, film, 3)), np.zeros((discs, film, 3, 3))
    coverage, spans = np.full((discs, film), -1.0), np.zeros((discs, film, 2), dtype=np.intp)
    accepted, size, own = np.empty((2, 0)), 0, np.empty(discs, dtype=np.intp)
    for k in range(film):
        count = shown(seen[1], k, own)
        if count == 0:
            continue
        around, starts = np.empty((count, 3)), np.empty((count, 3))
        shadows, margins = np.empty((count, hidden[0].shape[2], 2)), np.empty(count)
        for n in range(count):
            around[n], starts[n] = seen[0][own[n], k], seen[0][own[n], k]
            starts[n, 2] = radii[own[n]]
            shadows[n], margins[n] = hidden[0][own[n], k], hidden[1][own[n]]
        a, b = curves[2][k, 0], curves[2][k, 1]
        edges = curves[0][0, a:b], curves[0][1, a:b], curves[0][2, a:b], curves[0][3, a:b]
        errors = np.zeros((count, 3, 3))
        points, ends, shares = settle_outlines(
            edges, (starts, errors), around, (shadows, margins), limits
        )
        outlines = circles, covariance, coverage, accepted, spans
        again = starts, errors, shares, points, ends
        accepted, size = keep(again, own[:count], k, outlines, size)
    return circles, covariance, coverage, accepted, spans


@compiled
def filtered_otherwise(
    frames: Singles, filters: Filters, circles: Floats, limits: tuple[float, bool]
) -> tuple[Floats, Floats]:
    """Return circles and coverage of known discs as another filter gives them.

    Parameters
    ----------
    frames
        Those that are looked at, shape (frames, rows, columns).
    circles
        Shape (discs, frames, 3).
    limits
        Distance to keep off other discs, pixels, and that radii are free.

    Returns
    -------
    Shapes (discs, frames, 3) and (discs, frames).
    """
    discs, film = circles.shape[:2]
    circles_otherwise, coverage = np.empty((discs, film, 3)), np.empty((discs, film))
    hidden = np.empty((discs, 0, 2)), np.ones(discs)
    for k in range(film):
        starts = circles[:, k].copy()
        windows, fitted = starts.copy(), starts.copy()
        windows[:, 2] += LIMB_REACH_PX + 1.0
        points, _, _ = edges_about(frames[k], windows, filters[0], filters[1])
        edges = points[0], points[1], points[2], points[3]
        outlines = fitted, np.empty((discs, 3, 3))
        _, _, shares = settle_outlines(edges, outlines, starts, hidden, limits)
        circles_otherwise[:, k], coverage[:, k] = fitted, shares
    return circles_otherwise, coverage


@compiled
def film_ellipses(
    curves: FilmCurves, seen: tuple[Floats, Floats], radii: Floats, front: NDArray[np.bool_]
) -> tuple[Floats, Floats, Floats, Indices, Indices]:
    """Find the markers in all discs of a film, as `marker_curves.dark_ellipses` those of a frame.

    Parameters
    ----------
    seen
        Circles and coverages, shape (discs, frames, 3) and (discs, frames).
    radii, front
        Known radius of each disc, pixels, and whether the front view shows it, shape (discs,).

    Returns
    -------
    Ellipses, shape (markers, 6), directions, shape (markers, 3), and facing, disc and frame of
    each, shape (markers,), frame after frame and within each disc after disc.
    """
    discs, film = seen[1].shape
    most, count = curves[1].size // LEAST_POINTS, 0
    ellipses, directions, facing = np.empty((most, 6)), np.empty((most, 3)), np.empty(most)
    disc, frame = np.empty(most, dtype=np.intp), np.empty(most, dtype=np.intp)
    own = np.empty(discs, dtype=np.intp)
    for k in range(film):
        here = shown(seen[1], k, own)
        around, places = np.empty((here, 3)), np.empty((here, 3))
        in_front = np.empty(here, dtype=np.bool_)
        for n in range(here):
            around[n], places[n] = seen[0][own[n], k], seen[0][own[n], k]
            places[n, 2], in_front[n] = radii[own[n]], front[own[n]]
        a, b = curves[2][k, 0], curves[2][k, 1]
        points = curves[0][0, a:b], curves[0][1, a:b], curves[0][2, a:b], curves[0][3, a:b]
        found = dark_ellipses(points, curves[1][a:b], places, around, in_front)
        for n in range(found[3].size):
            ellipses[count], directions[count] = found[0][n], found[1][n]
            facing[count], disc[count], frame[count] = found[2][n], own[found[3][n]], k
            count += 1
    return ellipses[:count], directions[:count], facing[:count], disc[:count], frame[:count]
