"""What to measure next where a campaign came as a table: no rig of ours fires it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from analysis.model.verdict.standing import Standing, Word
from rigctl.documents import Json
from rigctl.page.model.compare import parsed
from rigctl.page.model.story.cards import named

SPEED = "ln v_n"
NO_SHOTS = frozenset({Word.FLOOR})
FACTOR = 1.5
"""So far beyond the least and the largest speed a further one is worth its effort."""
WIDE = 1.3
"""A gap between neighbouring speeds is named from this ratio on."""


def is_table(found: Json) -> bool:
    """Say whether a fit's campaign has no poses: nobody knows what another shot would show."""
    return not found["paths"]


def none_needed(standing: Standing) -> str:
    """Say that no shots are needed: as what is missing is named, or as nothing is."""
    if standing.word is Word.FLOOR:
        return "None are needed: these shots show nothing that is missing."
    return "None are needed to name what is missing."


def next_measurements(found: Json, standing: Standing) -> str:
    """Say which measurements would tell most, by the speeds that the table has."""
    speeds = speeds_of(found)
    if standing.word in NO_SHOTS:
        return none_needed(standing)
    if len(speeds) < 2:
        return "Measure more impacts, at several approach speeds: these have one alone."
    why = "laws that agree in between part there"
    if standing.tell is not None:
        one, other = (named(name) for name in standing.tell)
        why = f"{one} and {other}, which agree in between, part there"
    low, high = speeds[0] / FACTOR, speeds[-1] * FACTOR
    said = f"Measure next below {low:.2g} m/s and above {high:.2g} m/s: {why}."
    ratio, left, right = max((b / a, a, b) for a, b in pairwise(speeds))
    if ratio > WIDE:
        said += f" The widest gap of the table lies between {left:.2g} and {right:.2g} m/s."
    return said


def speeds_of(found: Json) -> Sequence[float]:
    """Return the approach speeds of a table, ascending, m/s; none where no finding has them."""
    cell = next((one for one in found["findings"] if one["covariate"] == SPEED), None)
    return [] if cell is None else sorted({math.exp(x) for x in parsed(cell["points"])["x"]})
