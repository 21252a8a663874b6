"""How much likelier a disc is a ball beside others like it: balls lie and fly in company.

A fist or a letter has by chance a sure disc of its own size near it; coins of a tray, balls of a
rack and exposures of one flight have several.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from analysis.balls.discs.disc import Disc

SURE, LIKE = 1.0, 1.3
"""Logarithm of the odds of a disc that counts as company, and how much larger the one is than the
other, at most."""
FAR = 10.0
"""Distance in radii, from rim to rim nearly, at which one like disc counts once: by chance it lies
nearer as the square of the distance."""
WEIGHT, MOST = 1.4, 3.0
"""Of the logarithm of what is counted, in that of the odds; and at most."""


def company(disc: Disc, others: Iterable[tuple[Disc, float]]) -> float:
    """Return what is added to the logarithm of the odds that a disc is a ball.

    Parameters
    ----------
    others
        Discs found before, each with the logarithm of its own odds.
    """
    counted = 0.0
    for other, odds in others:
        small, large = sorted((disc.radius, other.radius))
        apart = math.hypot(disc.row - other.row, disc.column - other.column)
        if odds >= SURE and large < LIKE * small and apart > large:
            counted += (FAR / (1.0 + apart / disc.radius)) ** 2
    return min(MOST, WEIGHT * math.log1p(counted))
