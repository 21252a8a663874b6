"""What a slider needs to move the model's curve and its error without asking anybody."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

import numpy as np

from analysis.model.structure.findings import ALWAYS
from rigctl.documents import Json
from rigctl.page.model.compare import parsed
from rigctl.page.model.story.errors import Unseen

POINTS = 60
LOOKED_AT = 12
"""Of the cells that show most: the points of one are thousands of characters to read."""


@dataclass(frozen=True, slots=True)
class Preview:
    """One effect's curve over one cell, and the error without it and at its best amplitude.

    Attributes
    ----------
    best, sigma
        Amplitude of the full fit and its standard error.
    x, curve
        What the model gains at the best amplitude, at `POINTS` places.
    without, with_it
        Error on unseen shots, as `Unseen` states it.
    """

    best: float
    sigma: float
    x: list[float]
    curve: list[float]
    without: float
    with_it: float

    def at(self, amplitude: float) -> float:
        """Return the error at an amplitude: a parabola in its square, least at the best one."""
        share = 1 - amplitude / self.best
        return math.sqrt(self.with_it**2 + (self.without**2 - self.with_it**2) * share**2)

    def document(self) -> Json:
        """Return it as the browser's slider takes it."""
        return asdict(self)


def preview(before: Json, after: Json, effect: str, points: tuple[Json, Json]) -> Preview | None:
    """Return the preview from two full fits, without an effect and with it.

    The model gains what its residuals lose: the running means of the same cell differ by the
    curve of the effect, while the noise of the shots stays in both.

    Parameters
    ----------
    points
        Of one cell, in the fit before and in the fit after.
    """
    found = next(
        (value for name, value in after["parameters"].items() if name.startswith(f"{effect}.")),
        None,
    )
    if found is None or not found["value"]:
        return None
    first, second = points[0]["trend"], points[1]["trend"]
    x = np.linspace(min(first["x"]), max(first["x"]), POINTS)
    curve = np.interp(x, first["x"], first["mean"]) - np.interp(x, second["x"], second["mean"])
    return Preview(
        best=found["value"],
        sigma=found.get("sigma") or 0.0,
        x=[float(f"{value:.5g}") for value in x],
        curve=[float(f"{value:.5g}") for value in curve],
        without=Unseen.of(before).value,
        with_it=Unseen.of(after).value,
    )


def plainest(before: Json, after: Json | None) -> tuple[Json, Json, Json] | None:
    """Return the cell whose points an effect's curve explains best, and its points in both fits.

    None without a second fit, or if both have no cell in common.
    """
    after_cells = {} if after is None else {_name(cell): cell for cell in after["findings"]}
    best, most = None, -math.inf
    for cell in before["findings"][:LOOKED_AT]:
        if cell["covariate"] == ALWAYS or _name(cell) not in after_cells:
            continue
        points = parsed(cell["points"]), parsed(after_cells[_name(cell)]["points"])
        if (share := _explained(*points)) > most:
            best, most = (cell, *points), share
    return best


def _explained(before: Json, after: Json) -> float:
    """Return the share of the residuals' variance that goes with the difference of the means."""
    first, second = before["trend"], after["trend"]
    x, residual = np.asarray(before["x"]), np.asarray(before["residual"])
    curve = np.interp(x, first["x"], first["mean"]) - np.interp(x, second["x"], second["mean"])
    whole = float(np.var(residual))
    return 1.0 - float(np.var(residual - curve)) / whole if whole > 0 else 0.0


def _name(cell: Json) -> tuple[str, str]:
    return cell["channel"], cell["covariate"]
