"""All discs of one picture whose diameter lies in a range: spheres, coins, beads of any size."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.imaging.discs import discs, vote
from analysis.imaging.edge.frame import (
    EdgeSettings,
    FrameEdges,
    find_edges,
    gradient_threshold,
    noise_sd,
)
from analysis.imaging.outlines import Outline, Place, fit_outline

RADIUS_STEP = 0.03
LEAST_RIM_SHARE = 0.2
LEAST_COVERAGE = 0.4
"""Share of the rim that a disc shows."""
MOST_OVERLAP = 0.75
"""Two discs whose centres are nearer than this share of their radii together are one."""
LEAST_STRENGTH_SHARE = 0.15
"""Edges weaker than this share of the strong ones are texture."""
STRONG_PERCENTILE = 95.0


@dataclass(frozen=True, slots=True)
class FoundDisc:
    """A disc: centre and radius in pixels with their standard errors, share of its rim seen.

    The errors are those of the fit, from the scatter of the edge points. Shading moves an edge by
    more (docs/explanation/measurement.md).
    """

    row: float
    column: float
    radius: float
    row_sigma: float
    column_sigma: float
    radius_sigma: float
    coverage: float


def find_discs(
    image: NDArray[np.uint8], diameters_px: tuple[float, float], sigma_px: float | None = None
) -> list[FoundDisc]:
    """Find all discs of a picture, the most complete first.

    Every edge point votes for centres along its normal at each radius of the range in steps of
    3 per cent. From the best peaks downwards an outline is fitted; one that shows two fifths of its
    rim and is not a disc found before is kept.

    Parameters
    ----------
    image
        Grey levels, shape (rows, columns).
    diameters_px
        Smallest and largest diameter.
    sigma_px
        Width of the edge filter; None: that of the analysis of shots.
    """
    settings = EdgeSettings() if sigma_px is None else EdgeSettings(sigma_px)
    edges = _strong_edges(image, settings)
    found: list[Outline] = []
    for place in _candidates(edges, diameters_px):
        outline = fit_outline(edges.points, place, [], 0.0)
        if outline is None or outline.coverage < LEAST_COVERAGE:
            continue
        if not diameters_px[0] <= 2 * outline.circle.radius <= diameters_px[1]:
            continue
        if not any(_one(outline, other) for other in found):
            found.append(outline)
    return [_described(outline) for outline in sorted(found, key=lambda o: -o.coverage)]


def _strong_edges(image: NDArray[np.uint8], settings: EdgeSettings) -> FrameEdges:
    noise = gradient_threshold(noise_sd(image[None]), settings.sigma_px)
    edges = find_edges(image, settings, noise)
    if len(edges.points) == 0:
        return edges
    strong = LEAST_STRENGTH_SHARE * float(np.percentile(edges.points.strength, STRONG_PERCENTILE))
    kept = edges.points.strength >= strong
    return FrameEdges(edges.shape, edges.points.where(kept), edges.labels[kept])


def _candidates(edges: FrameEdges, diameters_px: tuple[float, float]) -> list[Place]:
    """Return peaks of the votes at all radii, the fullest rim first."""
    low, high = diameters_px[0] / 2, diameters_px[1] / 2
    steps = int(np.ceil(np.log(high / low) / RADIUS_STEP)) + 1
    peaks: list[tuple[float, Place]] = []
    for radius in np.geomspace(low, high, steps).tolist():
        votes = vote(edges.points, radius, edges.shape)
        peaks.extend(
            (disc.rim_share, (disc.row, disc.column, radius))
            for disc in discs(votes, LEAST_RIM_SHARE, radius)
        )
    return [place for _, place in sorted(peaks, reverse=True)]


def _one(outline: Outline, other: Outline) -> bool:
    a, b = outline.circle, other.circle
    apart = float(np.hypot(a.row - b.row, a.column - b.column))
    return apart < MOST_OVERLAP * (a.radius + b.radius)


def _described(outline: Outline) -> FoundDisc:
    circle = outline.circle
    sigma = np.sqrt(np.diag(circle.covariance))
    return FoundDisc(
        row=circle.row,
        column=circle.column,
        radius=circle.radius,
        row_sigma=float(sigma[0]),
        column_sigma=float(sigma[1]),
        radius_sigma=float(sigma[2]),
        coverage=outline.coverage,
    )
