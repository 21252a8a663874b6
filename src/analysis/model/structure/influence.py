"""How much of a finding two shots may carry before it is theirs and not the campaign's."""

from __future__ import annotations

import numpy as np

MOST_CARRIED, MOST_CARRIED_OF_FEW, MANY, FEW = 0.6, 0.85, 60, 12
"""No finding is believed of whose fall two of many, or of few, shots carry more than this share."""


def most_carried(shots: int) -> float:
    """Return the share of a finding that two of so many shots may carry.

    Between few and many shots it falls with their logarithm.
    """
    ends = np.log([FEW, MANY])
    return float(np.interp(np.log(max(shots, 1)), ends, [MOST_CARRIED_OF_FEW, MOST_CARRIED]))
