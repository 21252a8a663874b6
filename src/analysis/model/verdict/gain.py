"""Whether what an effect gains on shots left out is the campaign's, or that of a few shots.

A real effect lowers the error of most shots in which it acts; a chance one, or one that stands in
for an error of some shots, that of few. F. Wilcoxon's signed ranks of the gains tell them apart: an
effect of score d, spread over many shots, has a sum of signed ranks of about d / 2 standard
deviations.
"""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats

MOST_ASKED = 3.0
ALLOWED = 2.0
"""Standard deviations by which a real effect may fall below what its score lets expect."""
OF_ATTAINABLE = 0.5
"""Of few shots even gains in all of them add up to little: 2.8 for ten."""
BEST, STRONG = 2, 36.0
"""A fall of six standard errors and more must be there without the two shots that gain most."""


def signed_rank(gains: Floats) -> float:
    """Return sum sign(D) rank|D| / sqrt(sum rank^2) of gains D, shape (S,).

    Near a unit normal where gains and losses are alike; 0 without any.
    """
    ranks = ranks_of(np.abs(gains)) * (gains != 0)
    size = float(np.sqrt((ranks**2).sum()))
    return float((np.sign(gains) * ranks).sum() / size) if size > 0 else 0.0


def ranks_of(values: Floats) -> Floats:
    """Return the rank of each number, from 1, shape (S,); equal ones share their mean rank."""
    _, place, count = np.unique(values, return_inverse=True, return_counts=True)
    return (np.cumsum(count) - (count - 1) / 2)[place]


def is_shared(gains: Floats, delta_chi2: float) -> bool:
    """Tell whether the shots share a gain, given the fall of chi-squared in units of the noise.

    Parameters
    ----------
    gains
        By how much the whitened squares of each shot left out fall, shape (S,).
    """
    attainable = signed_rank(np.arange(1.0, len(gains) + 1.0))
    expected = 0.5 * float(np.sqrt(max(delta_chi2, 0.0))) - ALLOWED
    asked = min(expected, MOST_ASKED, OF_ATTAINABLE * attainable)
    rest = np.sort(gains)[:-BEST] if len(gains) > 2 * BEST and delta_chi2 > STRONG else gains
    return signed_rank(gains) > asked and float(rest.sum()) > 0
