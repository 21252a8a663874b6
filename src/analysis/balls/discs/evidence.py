"""How likely a circle is a ball's rim, from all that the picture shows along it and beside it.

Gradients that point to a centre are no rim yet: those of a soft blotch do everywhere in it, a
cluttered ground has some at each circle's side, and heads, fingertips and elbows have a long round
piece of outline. A limit on one of these alone would lose balls: the terms here are weighed
together, as logarithms of odds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats, Singles
from analysis.balls.discs.along import REACH, RING, RING_PX, middle_of, rim_of
from analysis.balls.discs.colours import Colours
from analysis.balls.discs.disc import Disc
from analysis.balls.discs.gradient import (
    Gradient,
    derivatives,
    gradient,
    gradient_of,
    window_about,
)
from analysis.balls.discs.judging import SECTORS, sectors
from analysis.balls.discs.least_sum import least_sum

RADIUS_PX, NARROW_PX = 40.0, 60.0
"""Larger circles are looked at in a smaller picture, where they have this radius: in a window where
circles beside it lie, and in a narrow one."""
BEYOND, NARROW = 1.3, 0.35
"""How far these windows go beyond the circle, in radii. In the narrow one an edge is stronger than
what is next to the circle."""
BESIDE, BESIDE_TURNS = (0.4, 0.8), 8
"""How far beside it others lie, in radii, and in how many directions."""
CLOSE_PX = 0.6
CLOSELY, NEARLY = (0.02, math.cos(math.radians(12.0))), (0.03, math.cos(math.radians(15.0)))
"""Distance from a circle in radii, at least `CLOSE_PX`, and cosine of the angle with its radius, of
edges on it."""
LEAST_SHOWN = 0.5
"""Share of a circle that is in the window, at least."""
BORDER_PX = 2.0
"""Next to the picture's border no edge is found."""

STEEP, ALONG = 0.9, 0.8
"""Share of a change that is along the radius where it tells how round a rim is, and where it is
part of one."""
LOOSELY_PX, LOOSELY = 1.0, 0.06
"""How far off the circle, in pixels at least and in radii, a change is part of the rim."""
LEAST_EDGES = 20
WITHIN, STRONG = 0.85, 0.5
"""How far from the centre edges are within the rim, in radii, and how strong, in the rim's changes,
those are that count."""
MOST_CONTRAST = 3.0
"""Logarithm of a step at the rim, in the least size of an edge, above which more says nothing."""
INSIDE, LEAST_CLEAR = 1.02, 0.3
"""Within so many radii of a surer disc a sector is hidden; if fewer than this share are clear, all
count."""
HIDES = -15.0
"""log10 of false alarms of a disc that hides others."""
CONCENTRIC = 0.3
"""Two circles whose centres are nearer than this share of the larger radius hide nothing of each
other."""
BEFORE, ALIKE = 0.5, 2.0
"""How far a ball covers its shadow, in the smaller one's radii, and how much larger one is than the
other, at most."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """What the picture shows of a circle.

    Attributes
    ----------
    alarms
        Natural logarithm of minus log10 of the number of false alarms.
    close, narrow
        Share of its sectors with an edge that lies closely on it, in both windows.
    clutter
        The same, less closely, of the median circle of its size beside it.
    rim
        Share of clear sectors with a change along the radius near it.
    ragged
        Logarithm of the median distance of its strongest changes from a circle, in radii.
    uneven
        Logarithm of the median difference of its inside along the rim, in steps at the rim.
    agree
        Share of sectors whose step is as the median one.
    solid
        Logarithm of the difference of its middle from the outside, in steps at the rim, at most 1:
        a ring has none.
    hollow
        Difference of its middle from what is within the rim, in steps.
    open
        Logarithm of the share of its inside that has the colour of the outside: a letter, a net or
        a wire does not cover its ground.
    busy
        Length of strong edges within the rim, in that of the circle.
    contrast
        Logarithm of the step at the rim, in the least size of an edge.
    shadow
        Whether it is a ball's shadow: its ground with less light, partly covered by a surer disc of
        another colour.
    """

    alarms: float
    close: float
    narrow: float
    clutter: float
    rim: float
    ragged: float
    uneven: float
    agree: float
    solid: float
    hollow: float
    open: float
    busy: float
    contrast: float
    shadow: bool

    def log_odds(self) -> float:
        """Return the logarithm of the odds that this is a ball, of circles found in photographs."""
        if self.narrow < LEAST_NARROW or self.solid < LEAST_SOLID or self.shadow:
            return -math.inf
        return CONSTANT + sum(
            weight * float(getattr(self, name)) for name, weight in WEIGHTS.items()
        )


LEAST_NARROW = 0.15
"""Without edges there is no rim, however many gradients point to a centre."""
LEAST_SOLID = math.log(0.05 + 0.15)
"""What differs less from its ground in its middle, in steps at its rim, is a ring: a letter, a
printed circle."""
CONSTANT = -15.91
WEIGHTS = {
    "alarms": 1.73,
    "close": 4.2,
    "narrow": 5.56,
    "clutter": -4.26,
    "rim": -1.85,
    "ragged": -1.7,
    "uneven": 1.42,
    "agree": -0.51,
    "solid": 0.87,
    "hollow": -0.69,
    "open": -1.79,
    "busy": -1.36,
    "contrast": 0.45,
}
"""Of a logistic regression on 1240 circles with fewer than 10^-5 false alarms, of 80 photographs,
labelled by hand, and of drawn pictures. Its prior is the weights by 93 other ones, of which nothing
else is left (decisions 0080, 0082 and 0085)."""


def log_odds(values: Singles, disc: Disc, sigma_px: float, others: list[Disc]) -> float:
    """Return the logarithm of the odds that a disc is a ball, by `evidence`."""
    seen = evidence(values, disc, sigma_px, others)
    return -math.inf if seen is None else seen.log_odds()


def evidence(values: Singles, disc: Disc, sigma_px: float, others: list[Disc]) -> Evidence | None:
    """Return what a picture shows of a disc; None where less than a third of it is in the picture.

    Parameters
    ----------
    values
        Shape (rows, columns, channels).
    others
        Discs of the picture, which may hide a part of this one.
    """
    window, corner, factor = _window(values, disc, BEYOND, RADIUS_PX)
    circle = _inward(disc, corner, factor)
    down, right = derivatives(window, sigma_px)
    found = gradient_of(down, right)
    inside, outside, changes, shown = rim_of(window, down, right, circle)
    if shown.sum() < LEAST_EDGES:
        return None
    off, along, steep = changes
    edge = shown & (steep > found.threshold)
    on_rim = edge & (along > ALONG) & (np.abs(off) < max(LOOSELY_PX, LOOSELY * circle[2]))
    clear = shown & _clear(disc, circle, others, corner, factor)
    if clear.sum() < LEAST_CLEAR * shown.sum():
        clear = shown
    middle = np.median(middle_of(window, circle), axis=0)
    colours = Colours(inside, outside, shown, clear, middle)
    balls = [_inward(other, corner, factor) for other in others if _covers(other, disc)]
    shown_of = [middle_of(window, ball) for ball in balls]
    before = [np.median(each, axis=0) for each in shown_of if len(each) > 0]
    rim = steep[on_rim & clear]
    least = STRONG * float(np.median(rim)) if len(rim) else found.threshold
    contrast = math.log(colours.step(clear) / found.threshold)
    return Evidence(
        alarms=math.log(max(1.0, -disc.log_alarms)),
        close=_share(found, circle, CLOSELY),
        narrow=_narrow(values, disc, sigma_px),
        clutter=float(np.median([_share(found, each, NEARLY) for each in _beside(circle)])),
        rim=float(on_rim[clear].mean()),
        ragged=math.log(max(0.01, _ragged(off, edge & (along > STEEP), circle[2]))),
        uneven=colours.uneven(),
        agree=colours.agree(),
        solid=colours.solid(),
        hollow=colours.hollow(),
        open=colours.open(window, circle),
        busy=_busy(found, circle, least),
        contrast=min(contrast, MOST_CONTRAST),
        shadow=colours.shaded() and any(colours.is_other(each) for each in before),
    )


def _window(
    values: Singles, disc: Disc, beyond: float, radius_px: float
) -> tuple[Singles, Floats, float]:
    """Return the picture about a disc, its corner, and by which factor it is made smaller."""
    place = np.array([disc.row, disc.column, disc.radius])
    window, corner = window_about(values, place, beyond)
    factor = max(1.0, disc.radius / radius_px)
    if factor > 1.0:
        size = tuple(max(8, round(side / factor)) for side in window.shape[1::-1])
        window = np.atleast_3d(cv2.resize(window, size, interpolation=cv2.INTER_AREA))
    return window, corner, factor


def _narrow(values: Singles, disc: Disc, sigma_px: float) -> float:
    window, corner, factor = _window(values, disc, NARROW, NARROW_PX)
    return _share(gradient(window, sigma_px), _inward(disc, corner, factor), CLOSELY)


def _inward(disc: Disc, corner: Floats, factor: float) -> Floats:
    row, column = (
        (v + 0.5) / factor - 0.5 for v in (disc.row - corner[0], disc.column - corner[1])
    )
    return np.array([row, column, disc.radius / factor])


def _turns() -> Floats:
    """Return directions (row, column) of the middles of a circle's sectors, shape (2, SECTORS)."""
    turns = 2.0 * np.pi * np.arange(SECTORS) / SECTORS
    return np.stack([np.sin(turns), np.cos(turns)])


def _clear(
    disc: Disc, circle: Floats, others: list[Disc], corner: Floats, factor: float
) -> NDArray[np.bool_]:
    """Return which sectors are outside surer discs, at both sides of the rim."""
    clear = np.ones(SECTORS, bool)
    off = np.maximum(RING_PX, np.array(RING) * circle[2])
    for other in others:
        apart = math.hypot(other.row - disc.row, other.column - disc.column)
        if other.log_alarms > HIDES or apart < CONCENTRIC * max(other.radius, disc.radius):
            continue
        middle = _inward(other, corner, factor)
        for away in (circle[2] - off[0], circle[2] + off[1]):
            at = circle[:2, None] + away * _turns() - middle[:2, None]
            clear &= np.hypot(*at) > INSIDE * middle[2]
    return clear


def _covers(ball: Disc, disc: Disc) -> bool:
    """Return whether a disc may be the shadow of a ball that covers a part of it."""
    apart = math.hypot(ball.row - disc.row, ball.column - disc.column)
    small, large = sorted((ball.radius, disc.radius))
    covered = small + large - apart > BEFORE * small
    return covered and apart > CONCENTRIC * large and large < ALIKE * small


def _busy(found: Gradient, circle: Floats, least: float) -> float:
    """Return the length of edges of at least a size within a circle, in that of the circle."""
    edges, size = found.edges, found.field[0]
    within = np.hypot(*(edges[:, :2] - circle[:2]).T) < WITHIN * circle[2]
    row, column = np.rint(edges[within, :2]).astype(int).T
    last = np.array(size.shape)[:, None] - 1
    row, column = np.clip(np.stack([row, column]), 0, last)
    return float((size[row, column] > least).sum()) / (2.0 * math.pi * float(circle[2]))


def _beside(circle: Floats) -> list[Floats]:
    turns = 2.0 * np.pi * np.arange(BESIDE_TURNS) / BESIDE_TURNS
    ways = np.stack([np.sin(turns), np.cos(turns), np.zeros_like(turns)], axis=1)
    return [circle + off * circle[2] * way for off in BESIDE for way in ways]


def _share(found: Gradient, circle: Floats, near: tuple[float, float]) -> float:
    """Return the share of a circle's sectors in the picture that have an edge near the circle."""
    turns = 2.0 * np.pi * (np.arange(SECTORS) + 0.5) / SECTORS
    places = circle[:2, None] + circle[2] * np.stack([np.sin(turns), np.cos(turns)])
    room = np.array(found.field.shape[1:])[:, None] - BORDER_PX
    shown = float(((places > BORDER_PX) & (places < room)).all(axis=0).mean())
    if shown < LEAST_SHOWN:
        return 0.0
    limits = np.array([max(CLOSE_PX, near[0] * circle[2]), near[1]])
    every = np.ones(len(found.edges), np.float32)
    return sectors(found.edges, every, np.ascontiguousarray(circle), limits) / shown


def _ragged(off: Floats, edge: NDArray[np.bool_], radius: float) -> float:
    """Return the median distance of a rim's changes from the circle through them, in radii."""
    if edge.sum() <= LEAST_EDGES:
        return REACH
    down, right = _turns()[:, edge]
    terms = [down, right, np.ones_like(down)]
    found, _ = least_sum(terms, off[edge])
    return float(np.median(np.abs(off[edge] - np.column_stack(terms) @ found))) / radius
