"""A found disc, and how two of them lie to each other."""

from __future__ import annotations

import math
from dataclasses import dataclass

SAME_CENTRE, SAME_RADIUS = 0.25, 0.25
"""Two circles nearer than these shares of the radius are one."""
SAME_RING = 0.15
"""A disc whose centre is nearer than this share of the larger radius belongs to the surer one."""
LEAST_OUTER, MOST_OUTER = 1.04, 4.0
"""How much larger a ball may be than the border of its lit part, or than a print on it."""
LIKE_RADIUS = 1.08
"""Discs whose radii differ by less than this factor are alike."""
PRINT = 0.45
"""A disc on a larger one, smaller than this share of it, is its gloss or a print."""
CLOSE, SURE_CLOSE, CLOSER = 0.55, -20.0, 0.4
"""Two circles nearer than the first share of the larger radius, of which the less sure one has a
larger log10 of false alarms than this, are one thing's that is no circle: a ball with its shadow.
Those nearer than the last one are in any case."""
WITHIN = 1.05
"""In radii: a circle within another reaches no further."""


@dataclass(frozen=True, slots=True)
class Disc:
    """A disc, pixels of the picture: centre and radius with standard errors.

    Attributes
    ----------
    rim
        Share of the rim whose gradient points to the centre.
    log_alarms
        log10 of how many such discs chance would show in a picture of this size.
    """

    row: float
    column: float
    radius: float
    row_sigma: float
    column_sigma: float
    radius_sigma: float
    rim: float
    log_alarms: float


def holds(outer: Disc, inner: Disc) -> bool:
    """Return whether a circle lies within another one and is not the same."""
    larger = outer.radius / inner.radius
    return LEAST_OUTER < larger < MOST_OUTER and within(inner, outer)


def within(inner: Disc, outer: Disc) -> bool:
    """Return whether a circle lies within another one."""
    apart = math.hypot(inner.row - outer.row, inner.column - outer.column)
    return apart + inner.radius < WITHIN * outer.radius


def on(small: Disc, large: Disc) -> bool:
    """Return whether a disc is the gloss or a print on another."""
    apart = math.hypot(small.row - large.row, small.column - large.column)
    return small.radius < PRINT * large.radius and apart < large.radius


def one(a: Disc, b: Disc) -> bool:
    """Return whether two circles are one ball's."""
    radius = max(a.radius, b.radius)
    apart = math.hypot(a.row - b.row, a.column - b.column)
    alike = abs(a.radius - b.radius) < SAME_RADIUS * radius
    # A ring within a sphere is its gloss, core or print.
    ring = apart < SAME_RING * radius
    return ring or (alike and apart < SAME_CENTRE * radius)


def doubled(unsure: Disc, other: Disc) -> bool:
    """Return whether a circle is a second one through a thing that another one goes through."""
    apart = math.hypot(unsure.row - other.row, unsure.column - other.column)
    share = apart / max(unsure.radius, other.radius)
    return share < CLOSER or (share < CLOSE and unsure.log_alarms > SURE_CLOSE)


def touch(a: Disc, b: Disc) -> bool:
    """Return whether two circles meet, or nearly."""
    apart = math.hypot(a.row - b.row, a.column - b.column)
    return apart < 1.1 * (a.radius + b.radius)


def same_rim(a: Disc, b: Disc) -> bool:
    """Return whether two circles are one rim, as closely as radii of like discs are."""
    apart = math.hypot(a.row - b.row, a.column - b.column)
    larger = max(a.radius, b.radius)
    return apart < SAME_RING * larger and larger < LIKE_RADIUS * min(a.radius, b.radius)
