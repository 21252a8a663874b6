"""Radius of the discs in each view: the scale of the picture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.errors import ShotRefusedError
from analysis.imaging.assignment import KEEP_OFF_SIGMAS
from analysis.imaging.frame import EdgeSettings, find_edges, gradient_threshold
from analysis.imaging.limb import LIMB_REACH_PX
from analysis.imaging.outlines import fit_outlines, nothing_hidden
from analysis.imaging.tracks import Spheres
from analysis.imaging.views import View

GOOD_COVERAGE = 0.6
NEARLY_BEST = 0.9
"""Of the best coverage, where none is good."""
FINER = 0.6
"""The second filter is this much narrower."""
FRAMES_TRIED = 6
FEWEST_PAIRS = 3
"""Outlines seen well through both filters, for a bias to be known."""


def view_radii(spheres: Spheres) -> dict[View, tuple[float, float]]:
    """Return for each view the median radius of spheres a and b over their frames, pixels.

    Raises
    ------
    ShotRefusedError
        A sphere is not seen well enough in any frame of a view.
    """
    radii: dict[View, tuple[float, float]] = {}
    for view in spheres[0]:
        medians = []
        for name, sphere in zip("ab", spheres, strict=True):
            outlines = sphere[view].outlines.values()
            good = [o.circle.radius for o in outlines if o.coverage >= GOOD_COVERAGE]
            if not good:
                raise ShotRefusedError(
                    "outlines",
                    f"sphere {name} shows at least {GOOD_COVERAGE:.0%} of its limb in no frame "
                    f"of the {view.value} view",
                )
            medians.append(float(np.median(good)))
        radii[view] = (medians[0], medians[1])
    return radii


def shared_radii(
    spheres: Spheres, diameters_m: tuple[float, float]
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
    for view in spheres[0]:
        seen = [
            (outline.coverage, outline.circle.radius / diameter)
            for sphere, diameter in zip(spheres, diameters_m, strict=True)
            for outline in sphere[view].outlines.values()
        ]
        if not seen:
            raise ShotRefusedError("outlines", f"no sphere is found in the {view.value} view")
        least = min(GOOD_COVERAGE, NEARLY_BEST * max(coverage for coverage, _ in seen))
        size = float(np.median([own for coverage, own in seen if coverage >= least]))
        radii[view] = (size * diameters_m[0], size * diameters_m[1])
    return radii


def filter_bias(
    frames: NDArray[np.uint8],
    spheres: Spheres,
    settings: EdgeSettings,
    noise: float,
) -> dict[View, float]:
    """Return by how much the filter makes the discs of each view too large, pixels.

    The zero of the Laplacian of Gaussian lies off a curved, shaded edge by an amount that grows
    with sigma^2 (for a flat disc by sigma^2 / (2 R)). Measured with a second, narrower filter on
    the same discs and carried on to sigma = 0, whatever the shading. 0 where too few outlines are
    seen well.
    """
    fine = EdgeSettings(FINER * settings.sigma_px, None, settings.samples_per_pixel)
    threshold = gradient_threshold(noise, fine.sigma_px)
    views = list(spheres[0])
    common = sorted(set.intersection(*(set(s[v].outlines) for s in spheres for v in views)))
    chosen = common[:: max(1, len(common) // FRAMES_TRIED)]
    differences: dict[View, list[float]] = {view: [] for view in views}
    limits = KEEP_OFF_SIGMAS * settings.sigma_px, False
    for k in chosen:
        coarse = [(view, s[view].outlines[k]) for s in spheres for view in views]
        starts = np.array([(o.circle.row, o.circle.column, o.circle.radius) for _, o in coarse])
        windows = starts + np.array([0.0, 0.0, LIMB_REACH_PX + 1.0])
        points = find_edges(frames[k], fine, threshold, windows).points
        finer = fit_outlines(points, starts, starts, nothing_hidden(len(starts)), limits)
        for (view, one), other in zip(coarse, finer, strict=True):
            if other is not None and min(other.coverage, one.coverage) >= GOOD_COVERAGE:
                differences[view].append(one.circle.radius - other.circle.radius)
    share = 1.0 / (1.0 - FINER**2)
    return {
        v: share * float(np.median(d)) if len(d) >= FEWEST_PAIRS else 0.0
        for v, d in differences.items()
    }
