"""Discs that are like those found already: one ball of several exposures, coins, beads of a tray.

Where the radius is known, a circle is looked for at each place by its edges alone, without a start
from votes that a faint or overlapped rim does not give; and what is found has to look like the
others: as sharp, and as bright and coloured against its ground.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Singles
from analysis.balls.discs.gradient import Gradient, candidates
from analysis.balls.discs.judging import false_alarms
from analysis.compiled import compiled

LEAST_VOTES, MOST_PLACES = 0.05, 40
"""Share of a rim that votes for a place where a circle is tried, and how many are."""
SAME_PLACE = 0.1
"""Places nearer than this share of the radius are one."""
VOTED = 0.02
"""Radii that vote, to both sides of the known one: the votes' blur is wider."""
MOST_MOVED, MOST_RESIZED, MOST_INSIDE = 0.3, 0.06, 0.055
"""In radii: how far a circle goes from its start to where it is surest, and less than the end."""
FIRST_STEP, OF_RADIUS, HALVINGS, MOST_STEPS = 0.06, 0.4, 3, 6
"""First step in radii and its share for the radius; how often it is halved; steps of each size."""
INNER, RING = 0.9, (1.1, 1.45)
"""In radii: the inside of a disc, and the ground about it."""
LOOK_PX = 8.0
"""Radius of a disc in the smaller picture in which looks are compared."""
LEAST_LIKE = 0.42
"""A disc's contrast in the others' direction of colour, in theirs; at most the inverse: the ground
changes, and exposures overlap."""


def circles(
    found: Gradient, weights: Singles, taken: Singles, radius: float, tests: float
) -> Floats:
    """Return circles of about a radius where they are surest, with their alarms and rims.

    Parameters
    ----------
    found, weights, taken
        Edges with their weights, and pixels of other discs' rims, shape (rows, columns): neither
        what has no weight nor what is taken counts.
    tests
        log10 of how many circles are tried.

    Returns
    -------
    Row, column, radius, log10 of false alarms, share of the rim that is seen; shape (N, 5).
    """
    edges = np.ascontiguousarray(found.edges[weights > 0.0])
    radii = (radius * (1.0 - VOTED), radius * (1.0 + VOTED))
    field = found.field.copy()
    field[0][taken > 0.0] = 0.0
    places = candidates(edges, taken.shape, radii, MOST_PLACES, LEAST_VOTES)[:, 1:3]
    kept: list[Floats] = []
    for place in places:
        if all(math.hypot(*(place - other)) > SAME_PLACE * radius for other in kept):
            kept.append(place)
    start = [np.array([row, column, radius]) for row, column in kept]
    every = [_surest(field, found.threshold, each, tests) for each in start]
    # One whose radius would go on beyond is a disc of another size.
    inside = [each for each in every if abs(each[2] / radius - 1.0) < MOST_INSIDE]
    return np.array(inside).reshape(-1, 5)


@compiled
def _surest(
    field: NDArray[np.float32], threshold: float, start: NDArray[np.float64], tests: float
) -> NDArray[np.float64]:
    """Return the circle near a start with the fewest false alarms, their log10, and its rim."""
    best = np.zeros(5)
    best[:3] = start
    best[3:] = false_alarms(field, threshold, start.copy(), tests)
    step = FIRST_STEP * start[2]
    for _ in range(HALVINGS):
        for _ in range(MOST_STEPS):
            here = best.copy()
            for k in range(3):
                for side in (-1.0, 1.0):
                    trial = here[:3].copy()
                    trial[k] += side * step * (OF_RADIUS if k == 2 else 1.0)
                    moved = max(abs(trial[0] - start[0]), abs(trial[1] - start[1]))
                    resized = abs(trial[2] - start[2])
                    if moved > MOST_MOVED * start[2] or resized > MOST_RESIZED * start[2]:
                        continue
                    alarms = false_alarms(field, threshold, trial, tests)
                    if alarms[0] < best[3]:
                        best[:3] = trial
                        best[3:] = alarms
            if best[3] >= here[3]:
                break
        step *= 0.5
    return best


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """How like the discs of one radius each place of a picture looks, in a smaller one."""

    likeness: Floats
    factor: float

    def like(self, row: float, column: float) -> bool:
        """Return whether a disc there would stand out from its ground as the others do."""
        rows, columns = self.likeness.shape
        i, j = (round((v + 0.5) / self.factor - 0.5) for v in (row, column))
        value = float(self.likeness[min(max(i, 0), rows - 1), min(max(j, 0), columns - 1)])
        return LEAST_LIKE < value < 1.0 / LEAST_LIKE


def look(values: Singles, radius: float, places: Floats) -> Look:
    """Return how like the discs at some places all others would look.

    The light inside less that of the ring about it, over the channels d, is compared with the mean
    m of the discs: (m C^-1 d) / (m C^-1 m), with C the covariance of d over the picture.

    Parameters
    ----------
    places
        Rows and columns of the discs, shape (N, 2).
    """
    factor = max(1.0, radius / LOOK_PX)
    size = tuple(max(1, round(side / factor)) for side in values.shape[1::-1])
    small = cv2.resize(values, size, interpolation=cv2.INTER_AREA)
    own = radius / factor
    reach = math.ceil(RING[1] * own)
    down, right = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    away = np.hypot(down, right) / own
    inside, ring = away < INNER, (away > RING[0]) & (away < RING[1])
    kernel = inside / inside.sum() - ring / ring.sum()
    found = cv2.filter2D(small, cv2.CV_32F, kernel, borderType=cv2.BORDER_REFLECT)
    change = np.atleast_3d(found).astype(np.float64)
    flat = change.reshape(-1, change.shape[2])
    spread = flat.T @ flat / len(flat)
    spread += 1e-6 * (np.trace(spread) + 1e-12) * np.eye(len(spread))
    scaled = np.rint((places + 0.5) / factor - 0.5).astype(int)
    rows, columns = (np.clip(scaled[:, k], 0, change.shape[k] - 1) for k in (0, 1))
    mean = change[rows, columns].mean(axis=0)
    along = np.linalg.solve(spread, mean)
    return Look(change @ along / max(float(mean @ along), 1e-12), factor)
