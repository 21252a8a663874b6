"""The points of a cell as the story draws them: places in mm and times in ms, beside other mm."""

from __future__ import annotations

from rigctl.documents import Json
from rigctl.page.model.compare import parsed

SMALLER = {"m": "mm", "s": "ms"}
"""Units of a covariate, each with the one a thousand times smaller that is read beside it."""


def points_of(cell: Json) -> Json:
    """Return the points of a cell, their covariate in mm or ms where it comes in m or s."""
    points = parsed(cell["points"])
    words, comma, unit = str(points["x_label"]).rpartition(", ")
    if not comma or unit not in SMALLER:
        return points
    trend = points["trend"]
    return {
        **points,
        "x_label": f"{words}, {SMALLER[unit]}",
        "x": [1e3 * x for x in points["x"]],
        "trend": {**trend, "x": [1e3 * x for x in trend["x"]]},
    }
