"""What a slider needs to move the model's curve and its error without asking anybody."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.model.structure.findings import ALWAYS, rank_of
from analysis.model.verdict.standing import SURE
from rigctl.documents import Json
from rigctl.page.model.story.errors import Unseen
from rigctl.page.model.story.points import points_of
from rigctl.page.model.where import block_of

POINTS = 60
LEAST_SHARE = 0.2
"""Of the variance of a cell's points: a curve that explains less is hardly seen among them."""
NEARLY = 0.15
"""Cells explained less by this share of the best say nearly as much."""
FEWEST, PARTS = 8, 5
"""Of the shots nearest to a place so many, or this part of all, say what is gained there."""
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
        What the model gains at the best amplitude, at places that have dots: where there are
        none between, the line is straight. At most `POINTS` of them.
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
        square = self.with_it**2 + (self.without**2 - self.with_it**2) * share**2
        return math.sqrt(max(0.0, square))

    def most(self, ends: Sequence[float]) -> float:
        """Return the largest error of a slider between two ends."""
        return max(self.with_it, *map(self.at, ends))

    def document(self) -> Json:
        """Return it as the browser's slider takes it."""
        return asdict(self)


def preview(before: Json, after: Json, effect: str, points: tuple[Json, Json]) -> Preview | None:
    """Return the preview from two full fits, without an effect and with it.

    The model gains what its residuals lose, as `gained` takes it from both fits.

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
    first = points[0]
    span = first["x"] if _by_shot(first) else first["trend"]["x"]
    x = _among(span)
    curve = gained(*points, x)
    return Preview(
        best=found["value"],
        sigma=found.get("sigma") or 0.0,
        x=[float(f"{value:.5g}") for value in x],
        curve=[float(f"{value:.5g}") for value in curve],
        without=Unseen.of(before).value,
        with_it=Unseen.of(after).value,
    )


Shown = tuple[Json, Json, Json]
"""A cell, and its points in the fit before and in the fit after."""


def plainest(before: Json, after: Json | None, place: str) -> Shown | None:
    """Return the cell whose points an effect's curve explains best, and its points in both fits.

    Cells of the place where the effect acts go first, as far as they show something that the
    effect explains: what a contact does to the flights is drawn in the picture more plainly, and
    says less about the contact. Of cells that are explained nearly alike, or alike as far as so
    many points can tell, the first is what happened, and settings the last. Where no cell shows it
    by itself, the one in which the curve is largest beside the scatter of the points. None without
    a second fit, or if both have no cell in common.

    Parameters
    ----------
    place
        Block in which the effect acts, as `block_of` names it; empty: nowhere by itself.
    """
    after_cells = {} if after is None else {_name(cell): cell for cell in after["findings"]}
    cells = [
        cell
        for cell in before["findings"]
        if cell["covariate"] != ALWAYS and _name(cell) in after_cells
    ]
    own = [c for c in cells if block_of(c) == place and c["p_familywise"] < SURE]
    for looked_at in (own, cells):
        shares = {}
        for number, cell in enumerate(looked_at[:LOOKED_AT]):
            points = points_of(cell), points_of(after_cells[_name(cell)])
            shares[number] = _explained(*points), (cell, *points)
        most = max((share for share, _ in shares.values()), default=-math.inf)
        if most >= LEAST_SHARE:
            _, (_, first, _) = max(shares.values(), key=lambda pair: pair[0])
            within = max(NEARLY * abs(most), _unsure(most, len(first["x"])))
            near = [found for share, found in shares.values() if share >= most - within]
            return min(near, key=lambda found: rank_of(found[0]["covariate"]))
    there = [cell for cell in cells if block_of(cell) == place] or cells

    def largest(looked_at: Iterable[Json]) -> Shown | None:
        found = [(cell, points_of(cell), points_of(after_cells[_name(cell)])) for cell in looked_at]
        return max(found, key=lambda one: size_among(*one[1:]), default=None)

    # Of each row its first cell, then all of that row: all cells would take seconds.
    best = largest({cell["channel"]: cell for cell in reversed(there)}.values())
    return best and largest(cell for cell in there if cell["channel"] == best[0]["channel"])


def size_among(before: Json, after: Json) -> float:
    """Return how large an effect's curve is beside the scatter of a cell's points, both as rms."""
    scatter = float(np.std(before["residual"]))
    curve = gained(before, after, np.asarray(before["x"]))
    return float(np.std(curve)) / scatter if scatter > 0 else 0.0


def _unsure(share: float, count: int) -> float:
    """Return about the standard error of a share of variance that is taken from so many points."""
    inside = min(1.0, max(0.0, share))
    return 2.0 * math.sqrt(inside / count) * (1.0 - inside)


def _explained(before: Json, after: Json) -> float:
    """Return the share of the residuals' variance that goes with the difference of the means."""
    x, residual = np.asarray(before["x"]), np.asarray(before["residual"])
    whole = float(np.var(residual))
    rest = float(np.var(residual - gained(before, after, x)))
    # A curve through the shots' own gains follows chance too, as far as it is free.
    free = 2 * PARTS if _by_shot(before) else 0
    rest *= len(x) / max(len(x) - free, 1)
    return 1.0 - rest / whole if whole > 0 else 0.0


def gained(before: Json, after: Json, at: Floats) -> Floats:
    """Return what the model gains in a cell at some places of its covariate, shape (G,).

    Of shots by each shot's own gain, in which its noise has no part: a line through the nearest
    ones, as a running mean of the residuals would cut every peak and turn away from both ends. Of
    frames by the fitted curves of both fits.
    """
    own = {shot: k for k, shot in enumerate(after["shots"])}
    both = [(k, own[shot]) for k, shot in enumerate(before["shots"]) if shot in own]
    if not _by_shot(before) or len(both) < FEWEST:
        first, second = before["trend"], after["trend"]
        found = np.interp(at, first["x"], first["mean"])
        return np.asarray(found - np.interp(at, second["x"], second["mean"]))
    here, there = np.transpose(both)
    x = np.asarray(before["x"])[here]
    gain = np.asarray(before["residual"])[here] - np.asarray(after["residual"])[there]
    return np.array([_line_at(x, gain, place) for place in at])


def _among(places: Sequence[float]) -> Floats:
    """Return places in their order, each once; of many `POINTS`, with both ends."""
    found = np.unique(places)
    if len(found) <= POINTS:
        return found
    return np.asarray(found[np.linspace(0, len(found) - 1, POINTS).round().astype(int)])


def _by_shot(points: Json) -> bool:
    return all(frame < 0 for frame in points["frames"])


def _line_at(x: Floats, y: Floats, place: float) -> float:
    """Return a straight line through the nearest points at a place, the nearer the more weight."""
    away = x - place
    distance = np.abs(away)
    near = np.sort(distance)[max(FEWEST, len(x) // PARTS) - 1]
    weight = np.clip(1.0 - (distance / (1.001 * near + 1e-300)) ** 3, 0.0, 1.0) ** 3
    slopes = np.stack([np.ones_like(away), away], axis=1)
    solved = np.linalg.lstsq(slopes * np.sqrt(weight)[:, None], y * np.sqrt(weight), rcond=1e-9)
    return float(solved[0][0])


def _name(cell: Json) -> tuple[str, str]:
    return cell["channel"], cell["covariate"]
