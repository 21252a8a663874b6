"""A ball that turns in place: the test that separates it from one that flies."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.balls.discs.disc import Disc, within
from analysis.balls.discs.finding import DOUBTFUL, at_rim, find_balls
from analysis.balls.discs.gradient import SIGMA_PX
from analysis.balls.films.film import Picture

Ints = NDArray[np.intp]
Flags = NDArray[np.bool_]
STAYING = 0.15
"""Of the frames looked at: a pixel that has changed in so many changes on its place."""
LEAST_STAYING, LEAST_WITHIN, LEAST_WITHIN_OUTLINE = 0.6, 0.85, 0.75
"""Of all changes: those on such pixels, those within a disc of the middle picture, and those within
one that such pixels draw. A codec makes others."""
SPREADS = 2.5
"""How far a disc's pixels reach from their middle, in median distances from it: a codec changes
others far away."""
LEAST_CHANGES = 50
"""Pixels of all frames together."""
NEAR = 0.15
"""In radii: discs of changes and of the middle picture that are so alike are one."""
OVER_RADII, OVER_PX = 1.05, 2.0
"""How far from a disc's centre a change may lie that is its own."""


def turning_ball(
    changed: Collection[Flags], ground: Picture, radii_px: tuple[float, float]
) -> Disc | None:
    """Return the disc on which nearly all changes of a film lie; None where there is none.

    Parameters
    ----------
    changed
        Which pixels of frames of the whole film differ from what stands still.
    ground
        What stands still, shape (rows, columns, channels).
    """
    counts = np.zeros(ground.shape[:2], dtype=np.intp)
    for one in changed:
        counts += one
    staying = counts >= max(2.0, STAYING * len(changed))
    changes = int(counts.sum())
    if changes < LEAST_CHANGES or counts[staying].sum() < LEAST_STAYING * changes:
        return None
    # Blotches draw the ball's outline, without what holds it and what lies behind. Its rim in the
    # middle picture is sharper, and all that a ball of few blotches shows.
    outline = np.where(staying, 255, 0).astype(np.uint8)[..., None]
    drawn = _disc_of(outline, counts, staying, (radii_px, LEAST_WITHIN_OUTLINE))
    own = _disc_of(ground, counts, staying, (radii_px, LEAST_WITHIN))
    if drawn is None:
        return own
    if own is not None:
        apart = np.hypot(drawn.row - own.row, drawn.column - own.column)
        near = max(apart, abs(drawn.radius - own.radius)) < NEAR * drawn.radius
        # Blotches about the axis of a ball that turns in the picture draw less than the ball.
        if near or within(drawn, own):
            return own
    return at_rim(np.ascontiguousarray(ground, dtype=np.float32), drawn, SIGMA_PX)


def _disc_of(
    picture: Picture, counts: Ints, staying: Flags, sought: tuple[tuple[float, float], float]
) -> Disc | None:
    """Return the surest disc of a picture that holds so large a share of all changes, if any."""
    radii_px, least = sought
    rows, columns = np.nonzero(staying)
    middle = np.median(rows), np.median(columns)
    row, column = np.mgrid[: picture.shape[0], : picture.shape[1]]
    for disc in _discs_about(picture, (rows, columns), radii_px):
        if np.hypot(middle[0] - disc.row, middle[1] - disc.column) > disc.radius:
            continue
        reach = OVER_RADII * disc.radius + OVER_PX
        within = np.hypot(row - disc.row, column - disc.column) < reach
        if counts[within].sum() > least * counts.sum():
            return disc
    return None


def _discs_about(
    picture: Picture, changed: tuple[Ints, Ints], radii_px: tuple[float, float]
) -> list[Disc]:
    """Return discs of a picture where something changes on its place, as wide as it."""
    low, high = [], []
    for each, length in zip(changed, picture.shape, strict=False):
        middle = np.median(each)
        reach = SPREADS * np.median(np.abs(each - middle)) + 1.0
        low.append(max(0, int(middle - reach)))
        high.append(min(length, int(middle + reach) + 1))
    # Blotches change nearly all of a ball, but some part of it may be hidden.
    margin = max(high[0] - low[0], high[1] - low[1])
    top, left = (max(0, each - margin) for each in low)
    window = picture[top : high[0] + margin, left : high[1] + margin]
    radii = max(radii_px[0], 0.3 * margin), min(radii_px[1], 1.2 * margin)
    if radii[1] <= radii[0]:
        return []
    found = find_balls(window, radii, DOUBTFUL)
    return [replace(disc, row=disc.row + top, column=disc.column + left) for disc in found]
