"""Discs that are like those found already: one ball of several exposures, coins, beads of a tray.

Where radius and step of the rim are known, from ground to disc in all colours, a rim is looked for
at each place by this step: by its sign, size and colour, towards the centre and on a circle. What
is found there is as whole as the rims of the others, nearly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Singles
from analysis.balls.discs.gradient import Ground
from analysis.balls.discs.judging import SAMPLE_PX, log_binomial_tail
from analysis.compiled import compiled, part

RADIUS_PX = 16.0
"""Larger discs are sought in a smaller picture, where they have this radius."""
LEAST_STEP, MOST_STEP = 0.3, 3.0
"""Of the others' step: a lamp at the side and the ground change it."""
MOST_TURNED = math.tan(math.radians(22.5))
"""Tangent of the angle between a rim's gradient and its radius."""
OTHER_COLOUR, NOISE = 1.0, 2.0
"""Change of another colour than the step's, in what changes in its colour; and in the noise."""
OFF_PX, OFF_RADII = 0.8, 0.03
"""How far a rim lies off its circle."""
LEAST_CHANCE = 0.01
"""Of a sample to look like a rim by chance: a picture's few things are not all by chance."""
APART = 0.5
"""Share of the samples that count as each for itself: neighbours share what the filter sees."""
AS_WHOLE = 0.6
"""Share of the rim that is seen, in that of the others'."""
SECTORS, SIDES = 32, 4
"""Parts of a rim; and straight sides of a figure that touch a circle without being one."""
LIKELY = -5.0
"""log10 of the number of false alarms of a disc that is like others."""
MOST_PLACES, GRID_PX = 40, 2
"""How many places are tried, and the grid they lie on."""
LEAST_FREE = 0.6
"""Share of a rim in the picture and free of known ones that counts as a whole one."""
FARTHEST, NOWHERE = 3.0, 1e6
"""Pixels that the steepest place lies off at most, as three pixels tell it; where none is."""
DIRECTIONS = 16
"""In which a sample's chance is counted."""
MOST_MOVED, MOST_RESIZED, MOST_INSIDE = 0.3, 0.06, 0.055
"""In radii: how far a circle goes from its start to where it is surest, and less than the end."""
FIRST_STEP, OF_RADIUS, HALVINGS, MOST_STEPS = 0.06, 0.4, 3, 6
"""First step in radii and its share for the radius; how often it is halved; steps of each size."""


@dataclass(frozen=True, slots=True, eq=False)
class _Steps:
    """Changes of a picture in units of the step at the rim of known discs.

    Attributes
    ----------
    field
        Shape (2 N + 1, rows, columns) for N channels: gradient (row, column) in the colour of the
        step, then in those across it, and how far the steepest place lies along it, pixels.
    free
        Pixels that count: not on the rims of known discs; shape (rows, columns).
    noise
        Change of another colour that noise makes.
    chance
        That a place looks like a rim in some direction.
    """

    field: Singles
    free: NDArray[np.bool_]
    noise: float
    chance: float


def shrunk(known: Floats) -> float:
    """Return the factor by which a picture is smaller in which discs like known ones are sought."""
    return max(1.0, float(np.median(known[:, 2])) / RADIUS_PX)


def circles(ground: Ground, known: Floats, others: Floats, tests: float) -> Floats:
    """Return circles whose rims are like those of known discs of about the same radius.

    Parameters
    ----------
    ground
        Of the picture, smaller by the factor of `shrunk`.
    known, others
        Rows, columns and radii of the discs that the circles are like, and of all that are known,
        shapes (M, 3) and (N, 3).
    tests
        log10 of how many circles are tried.

    Returns
    -------
    Row, column, radius, log10 of false alarms, share of the rim that is seen; shape (K, 5).
    """
    radius = float(np.median(known[:, 2]))
    factor = ground.factor
    steps = _steps(ground, _inward(known, factor), _inward(others, factor))
    every = np.ones_like(steps.free)
    own = np.array(
        [_seen_about(steps.field, every, each, steps.noise) for each in _inward(known, factor)]
    )
    whole = float(np.median(own[:, 2]))
    found = []
    for row, column in _places(steps, radius / factor):
        start = np.array([row, column, radius / factor])
        best = _surest(steps.field, steps.free, start, steps.noise, steps.chance)
        best[3] = APART * best[3] + tests
        # One whose radius would go on beyond is a disc of another size.
        inside = abs(best[2] / start[2] - 1.0) < MOST_INSIDE
        sectors = _seen_about(steps.field, steps.free, best[:3], steps.noise)[3]
        seen = best[4] > AS_WHOLE * whole and sectors > _of_sides(best[2])
        if inside and seen and best[3] < LIKELY:
            found.append(
                np.array([*((best[:2] + 0.5) * factor - 0.5), best[2] * factor, *best[3:]])
            )
    return np.array(found).reshape(-1, 5)


def _of_sides(radius: float) -> float:
    """Return the share of sectors where sides that touch a circle lie on it as near as a rim does.

    Each goes off it, or turns from it, by as much as a rim may; and half a sector counts as one.
    """
    off = max(OFF_PX, OFF_RADII * radius)
    half = min(math.acos(radius / (radius + off)), math.atan(MOST_TURNED))
    return SIDES * (half / math.pi + 0.5 / SECTORS)


def _inward(discs: Floats, factor: float) -> Floats:
    """Return rows, columns and radii in a picture smaller by a factor."""
    return np.column_stack([(discs[:, :2] + 0.5) / factor - 0.5, discs[:, 2] / factor])


def _steps(ground: Ground, known: Floats, others: Floats) -> _Steps:
    down, right = ground.down, ground.right
    step = np.median([_step(down, right, each) for each in known], axis=0)
    # In colours in which the calm ground changes equally, those of the step and across it.
    whitened = np.linalg.inv(np.linalg.cholesky(ground.spread))
    large = float(np.linalg.norm(whitened @ step)) + 1e-12
    axes, _ = np.linalg.qr(np.column_stack([whitened @ step, np.eye(len(step))[:, 1:]]))
    axes[:, 0] = whitened @ step / large
    field = _in_colours(down, right, (whitened.T @ axes / large).astype(np.float32))
    _fill_ridge(field)
    taken = np.zeros(down.shape[:2], np.uint8)
    for row, column, radius in others.tolist():
        width = max(1, round(2.0 * max(1.5, 0.05 * radius)))
        cv2.circle(taken, (round(column), round(row)), max(1, round(radius)), 1.0, thickness=width)
    free = taken == 0
    return _Steps(
        field, free, NOISE / large, max(LEAST_CHANCE, _chance(field, free, NOISE / large))
    )


@compiled
def _in_colours(
    down: NDArray[np.float32], right: NDArray[np.float32], colours: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Return changes in other colours, row and column of each in turn, and room for the ridge."""
    rows, columns, channels = down.shape
    field = np.zeros((2 * channels + 1, rows, columns), np.float32)
    for c in range(channels):
        for i in range(rows):
            for j in range(columns):
                for k in range(channels):
                    field[2 * c, i, j] += down[i, j, k] * colours[k, c]
                    field[2 * c + 1, i, j] += right[i, j, k] * colours[k, c]
    return field


def _step(down: Singles, right: Singles, circle: Floats) -> Floats:
    """Return the median over a rim of the change towards the centre, of each channel."""
    turns = 2.0 * np.pi * np.arange(64) / 64
    u, v = np.sin(turns), np.cos(turns)
    i, j = (np.rint(circle[k] + circle[2] * side).astype(int) for k, side in ((0, u), (1, v)))
    inside = (i >= 0) & (j >= 0) & (i < down.shape[0]) & (j < down.shape[1])
    i, j, u, v = i[inside], j[inside], u[inside, None], v[inside, None]
    return np.asarray(np.median(-(u * down[i, j] + v * right[i, j]), axis=0))


def _places(steps: _Steps, radius: float) -> NDArray[np.intp]:
    """Return the places of a grid about which most of a rim is seen, shape (N, 2)."""
    shares = _shares(steps.field, steps.free, radius, steps.noise)
    top = cv2.dilate(shares, np.ones((5, 5), np.uint8))
    rows, columns = np.nonzero((shares >= top) & (shares > 2.0 * steps.chance))
    order = np.argsort(-shares[rows, columns], kind="stable")[:MOST_PLACES]
    return GRID_PX * np.column_stack([rows, columns])[order]


@part
def _is_rim(
    field: NDArray[np.float32], at: tuple[int, int], u: float, v: float, noise: float
) -> bool:
    """Return whether a pixel changes towards -(u, v) as the rims of known discs do."""
    i, j = at
    change = -(u * field[0, i, j] + v * field[1, i, j])
    turned = abs(v * field[0, i, j] - u * field[1, i, j])
    if change < LEAST_STEP or change > MOST_STEP or turned > MOST_TURNED * change:
        return False
    square = 0.0
    for k in range(2, len(field) - 1, 2):
        square += (u * field[k, i, j] + v * field[k + 1, i, j]) ** 2
    return bool(math.sqrt(square) <= OTHER_COLOUR * change + noise)


@compiled
def _chance(field: NDArray[np.float32], free: NDArray[np.bool_], noise: float) -> float:
    """Return the share of pixels and directions that look like a rim, at its steepest."""
    samples = hits = 0
    for i in range(0, free.shape[0], GRID_PX):
        for j in range(0, free.shape[1], GRID_PX):
            if not free[i, j]:
                continue
            samples += DIRECTIONS
            if abs(field[-1, i, j]) > OFF_PX:
                continue
            for k in range(DIRECTIONS):
                turn = 2.0 * math.pi * k / DIRECTIONS
                hits += _is_rim(field, (i, j), math.sin(turn), math.cos(turn), noise)
    return hits / max(samples, 1)


@compiled
def _seen_about(
    field: NDArray[np.float32], free: NDArray[np.bool_], circle: NDArray[np.float64], noise: float
) -> tuple[int, int, float, float]:
    """Return free samples of a rim, those that look like one, and shares of samples and sectors."""
    return _seen(field, free, circle, noise, _turns(circle[2]))


@part
def _turns(radius: float) -> NDArray[np.float64]:
    """Return the directions (row, column) of a rim's samples from its centre, shape (N, 2)."""
    wanted = max(12, int(2.0 * math.pi * radius / SAMPLE_PX))
    turns = np.empty((wanted, 2))
    for k in range(wanted):
        turn = 2.0 * math.pi * k / wanted
        turns[k, 0], turns[k, 1] = math.sin(turn), math.cos(turn)
    return turns


@part
def _seen(
    field: NDArray[np.float32],
    free: NDArray[np.bool_],
    circle: NDArray[np.float64],
    noise: float,
    turns: NDArray[np.float64],
) -> tuple[int, int, float, float]:
    """Return what `_seen_about` does, from directions that circles of one radius share."""
    row, column, radius = circle
    wanted = len(turns)
    most = max(OFF_PX, OFF_RADII * radius)
    samples = hits = full = 0
    last = -1
    for k in range(wanted):
        u, v = turns[k]
        i, j = round(row + radius * u), round(column + radius * v)
        if i < 0 or j < 0 or i >= free.shape[0] or j >= free.shape[1] or not free[i, j]:
            continue
        samples += 1
        if field[-1, i, j] == NOWHERE or not _is_rim(field, (i, j), u, v, noise):
            continue
        size = math.sqrt(field[0, i, j] ** 2 + field[1, i, j] ** 2)
        along = field[-1, i, j] / size
        down, right = i + along * field[0, i, j] - row, j + along * field[1, i, j] - column
        if abs(math.sqrt(down**2 + right**2) - radius) < most:
            hits += 1
            sector = k * SECTORS // wanted
            full += sector != last
            last = sector
    share = max(samples / wanted, LEAST_FREE)
    return samples, hits, hits / (wanted * share), full / (min(SECTORS, wanted) * share)


@compiled
def _shares(
    field: NDArray[np.float32], free: NDArray[np.bool_], radius: float, noise: float
) -> NDArray[np.float32]:
    """Return the share of the rim that is seen about each place of a grid."""
    rows, columns = (free.shape[0] - 1) // GRID_PX + 1, (free.shape[1] - 1) // GRID_PX + 1
    shares = np.zeros((rows, columns), np.float32)
    circle = np.array([0.0, 0.0, radius])
    turns = _turns(radius)
    for i in range(rows):
        for j in range(columns):
            circle[0], circle[1] = GRID_PX * i, GRID_PX * j
            shares[i, j] = _seen(field, free, circle, noise, turns)[2]
    return shares


@compiled
def _fill_ridge(field: NDArray[np.float32]) -> None:
    """Fill in how far along the gradient in the step's colour the steepest place lies, pixels."""
    _, rows, columns = field.shape
    field[-1] = NOWHERE
    for i in range(2, rows - 2):
        for j in range(2, columns - 2):
            size = math.sqrt(field[0, i, j] ** 2 + field[1, i, j] ** 2)
            if size < LEAST_STEP:
                continue
            u, v = field[0, i, j] / size, field[1, i, j] / size
            before, after = _along(field, i - u, j - v, u, v), _along(field, i + u, j + v, u, v)
            curve = before - 2.0 * size + after
            if curve < 0.0:
                field[-1, i, j] = min(FARTHEST, max(-FARTHEST, 0.5 * (before - after) / curve))


@part
def _along(field: NDArray[np.float32], row: float, column: float, u: float, v: float) -> float:
    """Return the gradient in the step's colour along (u, v), between pixels."""
    i, j = int(row), int(column)
    p, q = row - i, column - j
    size = 0.0
    for di in range(2):
        for dj in range(2):
            weight = (p if di else 1.0 - p) * (q if dj else 1.0 - q)
            size += weight * (u * field[0, i + di, j + dj] + v * field[1, i + di, j + dj])
    return size


@compiled
def _surest(
    field: NDArray[np.float32],
    free: NDArray[np.bool_],
    start: NDArray[np.float64],
    noise: float,
    chance: float,
) -> NDArray[np.float64]:
    """Return the circle near a start that chance shows least, log10 of that, and its share."""
    best = np.zeros(5)
    best[:3] = start
    best[3:] = _sureness(field, free, best[:3], noise, chance)
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
                    sureness = _sureness(field, free, trial, noise, chance)
                    if sureness[0] < best[3]:
                        best[:3] = trial
                        best[3:] = sureness
            if best[3] >= here[3]:
                break
        step *= 0.5
    return best


@compiled
def _sureness(
    field: NDArray[np.float32],
    free: NDArray[np.bool_],
    circle: NDArray[np.float64],
    noise: float,
    chance: float,
) -> NDArray[np.float64]:
    """Return log10 of the chance of a rim that is seen so far, and its share that is seen."""
    samples, hits, share, _ = _seen(field, free, circle, noise, _turns(circle[2]))
    found = np.zeros(2)
    if hits > 0:
        found[0] = log_binomial_tail(samples, hits, chance)
    found[1] = share
    return found
