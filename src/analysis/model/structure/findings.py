"""What the structure that is left follows: the mean of each channel first, then what it follows.

One constant error would light every cell of its channel. It is a finding of its own, against
`ALWAYS`; the other cells hold the course that is left without it. Of covariates that say nearly the
same, what happened at the contact is named before where it happened, and both before settings,
which only bring it about.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from analysis.arrays import Floats

if TYPE_CHECKING:
    # The page takes a name from here, and starts without the model.
    from analysis.model.structure.lackoffit import Cell


ALWAYS = "always"
"""The covariate of a channel's mean."""
NEARLY = 0.85
"""Cells with this share of the largest deviation say nearly as much."""
CORRELATED = 0.9
"""Covariates correlated above this say the same of a channel."""
HOW_IT_HIT = ("ln v_n", "ln v_s/v_n", "spin along v_t x n", "spin about n")
WHERE = (*(f"contact {axis}" for axis in "XYZ"), "time", *(f"field {axis}" for axis in "XYZ"))


@dataclass(frozen=True, slots=True)
class Finding:
    """A channel against a covariate, or against `ALWAYS`.

    Attributes
    ----------
    deviation
        Standard deviations of the course without the channel's mean, or of that mean.
    p_holm
        Chance of that, with all cells, or all channels, looked at.
    """

    channel: str
    covariate: str
    deviation: float
    p_holm: float


def findings(cells: Sequence[Cell], covariates: Mapping[str, Floats]) -> tuple[Finding, ...]:
    """Return means and courses, the one to name first in front, the others by their deviations.

    Parameters
    ----------
    covariates
        Of the shots, each of shape (S,): which of them are correlated.
    """
    found = [
        Finding(cell.channel, cell.covariate, cell.course_deviation, cell.course_p_holm)
        for cell in cells
        if cell.freedom > cell.mean_freedom
    ]
    means = {
        cell.channel: Finding(cell.channel, ALWAYS, cell.mean_deviation, cell.mean_p_holm)
        for cell in cells
        if cell.mean_freedom
    }
    ordered = sorted([*found, *means.values()], key=lambda one: -one.deviation)
    if not ordered:
        return ()
    first = min(
        (one for one in ordered if _says_as_much(one, ordered[0], covariates)),
        key=lambda one: rank_of(one.covariate),
    )
    return (first, *(one for one in ordered if one is not first))


def rank_of(covariate: str) -> int:
    """Return the place of a covariate: always, how it hit, where; settings and the order alike."""
    known = (ALWAYS, *HOW_IT_HIT, *WHERE)
    return known.index(covariate) if covariate in known else len(known)


def _says_as_much(one: Finding, best: Finding, covariates: Mapping[str, Floats]) -> bool:
    if one.deviation >= NEARLY * best.deviation:
        return True
    pair = [covariates.get(each.covariate) for each in (one, best)]
    if one.channel != best.channel or pair[0] is None or pair[1] is None:
        return False
    if min(np.ptp(pair[0]), np.ptp(pair[1])) == 0:
        return False
    return bool(abs(np.corrcoef(pair[0], pair[1])[0, 1]) > CORRELATED)
