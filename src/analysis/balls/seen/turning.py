"""A ball that stays where it is and turns: how it is told from one that flies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.balls.discs.finding import DOUBTFUL, Disc, find_balls
from analysis.balls.films.film import Picture
from analysis.balls.seen.looks import CHANGED_SIGMAS, changes_of

Ints = NDArray[np.intp]

STAYING = 0.15
"""Of the frames looked at: a pixel that has changed in so many changes on its place."""
LEAST_STAYING, LEAST_WITHIN = 0.6, 0.85
"""Of all changes: those on such pixels, and those within the disc."""
LEAST_CHANGES = 50
"""Pixels of all frames together."""
OVER_RADII, OVER_PX = 1.05, 2.0
"""How far from a disc's centre a change may lie that is its own."""


def turning_ball(
    samples: Sequence[Picture], ground: Picture, noise: float, radii_px: tuple[float, float]
) -> Disc | None:
    """Return the disc on which nearly all changes of a film lie; None where there is none.

    Parameters
    ----------
    samples
        Frames of the whole film.
    ground
        Their middle.
    noise
        Standard deviation of a pixel that stands still.
    """
    counts = np.zeros(ground.shape[:2], dtype=np.intp)
    for sample in samples:
        counts += changes_of(sample, ground) > CHANGED_SIGMAS * noise
    staying = counts >= max(2.0, STAYING * len(samples))
    changes = int(counts.sum())
    if changes < LEAST_CHANGES or counts[staying].sum() < LEAST_STAYING * changes:
        return None
    rows, columns = np.nonzero(staying)
    middle = np.median(rows), np.median(columns)
    for disc in _discs_about(ground, (rows, columns), radii_px):
        reach = OVER_RADII * disc.radius + OVER_PX
        if np.hypot(middle[0] - disc.row, middle[1] - disc.column) > disc.radius:
            continue
        row, column = np.mgrid[: ground.shape[0], : ground.shape[1]]
        own = np.hypot(row - disc.row, column - disc.column) < reach
        if counts[own].sum() > LEAST_WITHIN * changes:
            return disc
    return None


def _discs_about(
    ground: Picture, changed: tuple[Ints, Ints], radii_px: tuple[float, float]
) -> list[Disc]:
    """Return discs of the middle picture where something changes on its place, as wide as it."""
    low = [int(np.percentile(each, 3)) for each in changed]
    high = [int(np.percentile(each, 97)) + 1 for each in changed]
    # Blotches change nearly all of a ball, but some part of it may be hidden.
    margin = max(high[0] - low[0], high[1] - low[1])
    top, left = (max(0, each - margin) for each in low)
    window = ground[top : high[0] + margin, left : high[1] + margin]
    radii = max(radii_px[0], 0.3 * margin), min(radii_px[1], 1.2 * margin)
    if radii[1] <= radii[0]:
        return []
    found = find_balls(window, radii, DOUBTFUL)
    return [replace(disc, row=disc.row + top, column=disc.column + left) for disc in found]
