"""Radius of the discs in each view, the scale of the picture; and outlines once more with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Grey, as_singles
from analysis.errors import ShotRefusedError
from analysis.imaging.assignment import KEEP_OFF_SIGMAS
from analysis.imaging.edge.frame import EdgeSettings, filters, gradient_threshold
from analysis.imaging.film_discs import FilmDiscs, film_discs
from analysis.imaging.film_following import FilmCurves
from analysis.imaging.film_passes import filtered_otherwise, refit_discs
from analysis.imaging.views import View, ViewGeometry

GOOD_COVERAGE = 0.6
NEARLY_BEST = 0.9
"""Of the best coverage, where none is good."""
FINER = 0.6
"""The second filter is this much narrower."""
FRAMES_TRIED = 6
MEDIAN_SIGMA = 1.4826 * 1.2533
"""Standard error of a median of normal values, over their median deviation and the root of their
number."""
FEWEST_PAIRS = 3
"""Outlines seen well through both filters, for a bias to be known."""


def view_radii(discs: FilmDiscs) -> dict[View, tuple[float, float]]:
    """Return for each view the median radius of spheres a and b over their frames, pixels.

    Raises
    ------
    ShotRefusedError
        A sphere is not seen well enough in any frame of a view.
    """
    radii: dict[View, tuple[float, float]] = {}
    for v, view in enumerate(discs.views):
        medians = []
        for i, name in enumerate("ab"):
            good = discs.circles[i, v, discs.coverage[i, v] >= GOOD_COVERAGE, 2]
            if good.size == 0:
                raise ShotRefusedError(
                    "outlines",
                    f"sphere {name} shows at least {GOOD_COVERAGE:.0%} of its limb in no frame "
                    f"of the {view.value} view",
                )
            medians.append(float(np.median(good)))
        radii[view] = (medians[0], medians[1])
    return radii


def shared_radii(
    discs: FilmDiscs, diameters_m: tuple[float, float]
) -> dict[View, tuple[float, float]]:
    """Return for each view the radius of spheres a and b, in the ratio of their diameters, pixels.

    The dark side of a sphere may be as bright as what lies behind it, and part of a limb gives a
    radius that is some per cent too small. So the best seen outlines speak for both spheres.

    Raises
    ------
    ShotRefusedError
        Neither sphere is found in any frame of a view.
    """
    radii: dict[View, tuple[float, float]] = {}
    sizes = discs.circles[..., 2] / np.array(diameters_m)[:, None, None]
    for v, view in enumerate(discs.views):
        coverage = discs.coverage[:, v]
        if not discs.found[:, v].any():
            raise ShotRefusedError("outlines", f"no sphere is found in the {view.value} view")
        least = min(GOOD_COVERAGE, NEARLY_BEST * float(coverage.max()))
        size = float(np.median(sizes[:, v][coverage >= least]))
        radii[view] = (size * diameters_m[0], size * diameters_m[1])
    return radii


@dataclass(frozen=True, slots=True, eq=False)
class FilterBias:
    """What the width of the edge filter does to outlines, pixels; 0 where too few are seen well.

    Attributes
    ----------
    radius
        By how much it makes the discs of each view too large.
    place, place_sigma
        By how much it shifts row and column of each sphere in each view, as the middle of all
        frames that were tried, and the standard error of that, shapes (2, views, 2).
    """

    radius: dict[View, float]
    place: Floats
    place_sigma: Floats


def filter_bias(
    frames: Grey,
    discs: FilmDiscs,
    settings: EdgeSettings,
    noise: float,
    tried: int = FRAMES_TRIED,
) -> FilterBias:
    """Return what the width of the filter does to the outlines of a film.

    The zero of the Laplacian of Gaussian lies off a curved, shaded edge by an amount that grows
    with sigma^2 (for a flat disc by sigma^2 / (2 R)); shading that differs around the limb shifts
    the disc by as much. Measured with a second, narrower filter on the same discs and carried on to
    sigma = 0, whatever the shading.

    Parameters
    ----------
    tried
        Frames that are looked at, at most twice as many.
    """
    fine = EdgeSettings(FINER * settings.sigma_px, None, settings.samples_per_pixel)
    circles, coverage = discs.flat()
    common = np.flatnonzero(discs.found.all(axis=(0, 1)))
    chosen = common[:: max(1, len(common) // tried)]
    finer, shares = filtered_otherwise(
        as_singles(frames[chosen]),
        filters(fine, gradient_threshold(noise, fine.sigma_px)),
        np.ascontiguousarray(circles[:, chosen]),
        (KEEP_OFF_SIGMAS * settings.sigma_px, False),
    )
    seats = 2, len(discs.views), len(chosen)
    good = (np.minimum(shares, coverage[:, chosen]) >= GOOD_COVERAGE).reshape(seats)
    off = (circles[:, chosen] - finer).reshape(*seats, 3) / (1.0 - FINER**2)
    radius = {view: _middle(off[:, v, :, 2], good[:, v])[0] for v, view in enumerate(discs.views)}
    place = np.array(
        [
            [[_middle(off[i, v, :, k], good[i, v]) for k in (0, 1)] for v in range(seats[1])]
            for i in (0, 1)
        ]
    )
    return FilterBias(radius, place[..., 0], place[..., 1])


def _middle(values: Floats, good: NDArray[np.bool_]) -> tuple[float, float]:
    """Return the median of the good values and its standard error, both 0 for too few."""
    if good.sum() < FEWEST_PAIRS:
        return 0.0, 0.0
    own = values[good]
    middle = float(np.median(own))
    return middle, MEDIAN_SIGMA * float(np.median(np.abs(own - middle))) / float(np.sqrt(own.size))


BLURRED_SIGMAS = 1.5
"""The filter carries a marker's edge this many sigma along the limb."""


@dataclass(frozen=True, slots=True, eq=False)
class Appearance:
    """What a first look at the whole shot has told.

    Attributes
    ----------
    radii
        For each view the radius of a and b, pixels.
    markers
        Directions of a's and of b's markers in rig axes, shape (frames, markers, 3); NaN in a
        frame where they are not known, which is refitted whole.
    marker_angle
        Angular radius of a marker, radians.
    """

    radii: dict[View, tuple[float, float]]
    markers: tuple[Floats, Floats]
    marker_angle: float


def refine_outlines(
    curves: FilmCurves,
    views: tuple[ViewGeometry, ...],
    discs: FilmDiscs,
    known: Appearance,
    sigma_px: float,
) -> FilmDiscs:
    """Fit every outline again with its radius held and the limb's marked stretches left out.

    Parameters
    ----------
    curves
        Edges of the film.
    """
    geometry = {own.view: own for own in views}
    seats = [(i, view) for i in (0, 1) for view in discs.views]
    radii = np.array([known.radii[view][i] for i, view in seats])
    most = max(own.shape[1] for own in known.markers)
    hidden = np.full((len(seats), discs.coverage.shape[-1], most, 2), np.nan)
    for own, (i, view) in zip(hidden, seats, strict=True):
        markers = known.markers[i]
        own[:, : markers.shape[1]] = geometry[view].offsets(markers)[..., :2]
    margins = np.cos(known.marker_angle + BLURRED_SIGMAS * sigma_px / radii)
    limits = KEEP_OFF_SIGMAS * sigma_px, True
    again = refit_discs(curves, discs.flat(), radii, (hidden, margins), limits)
    return film_discs(discs.views, again)
