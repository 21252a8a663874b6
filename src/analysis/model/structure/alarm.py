"""When structure that is left is believed to be more than the errors of single shots.

Stated errors of few shots cannot be checked: an outline or a marker that errs by more in one of
them leaves structure that no chance explains and no other shot repeats. What is missing in the
model shows in every shot that can see it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from analysis.model.structure.influence import FEW, most_carried

if TYPE_CHECKING:
    # The page takes a number from here, and starts without the model.
    from analysis.model.structure.lackoffit import Cell

UNEXPLAINED_LEVEL = 0.005
"""Chance of a cell in a campaign with nothing missing below which it alarms. One such campaign in a
hundred may: outliers and wrong sigmas need room below that."""
SHORT = 1.5
"""Error on shots left out, in units of the noise, beyond which what few shots leave over is no
error of two of them: what was found is then not all that is missing."""
FEWEST = 5
"""Of fewer shots nobody can say which of them errs: two are no finding, nor are two against two."""


def is_shared(cell: Cell, shots: int) -> bool:
    """Say whether a cell's structure is that of a campaign, and not of two of its shots alone.

    Of up to `FEW` shots the others have to alarm by themselves. Of more it is enough if two do not
    carry nearly all of it.
    """
    if shots < FEWEST:
        return False
    if cell.p_rest < UNEXPLAINED_LEVEL:
        return True
    return shots > FEW and cell.carried_share < most_carried(shots)


def alarms(cell: Cell, shots: int) -> bool:
    """Say whether a cell stands out, is shared, and is more than the measurement itself leaves."""
    stands_out = cell.p_holm < UNEXPLAINED_LEVEL and not cell.of_measurement
    return stands_out and is_shared(cell, shots)


def is_short(cells: Sequence[Cell], shots: int, prediction_error: float) -> bool:
    """Say whether few shots leave over more than the errors of two of them bring."""
    stands_out = any(c.p_holm < UNEXPLAINED_LEVEL and not c.of_measurement for c in cells)
    return FEWEST <= shots <= FEW and stands_out and prediction_error > SHORT
