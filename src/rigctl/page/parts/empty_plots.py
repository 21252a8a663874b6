"""A plot that is still empty shows what to do first."""

from __future__ import annotations

from rigctl.documents import Json
from rigctl.page.parts.plots import figure

NO_SHOTS = "No shot is measured yet:<br>fire one on the page Rig, or start a sweep."
NONE_OF_SWEEP = "No shot of this sweep is measured yet;<br>each appears here once it is."
READING = "Reading the shots …"
NO_SLIDING = "No measured shot slides enough<br>to tell: fire some with an offset."


def empty(words: str, height: int, name: str) -> Json:
    """Return a figure without axes that shows `words`, lines apart by `<br>`."""
    said = {
        "text": words,
        "showarrow": False,
        "xref": "paper",
        "yref": "paper",
        "x": 0.5,
        "y": 0.5,
        "font": {"size": 13},
    }
    return figure(
        [],
        height,
        name,
        margin={"l": 12, "r": 12, "t": 12, "b": 12},
        annotations=[said],
        xaxis={"visible": False, "fixedrange": True},
        yaxis={"visible": False, "fixedrange": True},
    )
