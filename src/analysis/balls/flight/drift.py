"""How fast a ball drifts away from the camera in each flight, by the size that it is seen with.

What drifts away is seen smaller, by as much as its distance grows; before a camera that looks down,
so is what flies higher. Sizes change otherwise too: aslant through a wide lens, by any amount here,
and where the ground or the light at the rim changes along the picture, by what is known.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.flight.flights import Observed
from analysis.balls.flight.known import Known

LIGHT_SIGMA = 6e-4
"""By how much the size of a ball that is lit from one side changes as it moves by its radius across
the picture, relative: what twelve rendered films had, beside their truth."""
CODEC_PX, NOTHING = 0.2, 1e-6
"""By how much a codec may keep the size of a ball that slowly becomes smaller or larger: it takes
over what has changed by little from frame to frame."""
LEAST_FRAMES = 12
OUTLIER = 4.0
"""Standard errors beyond which a size does not count."""
ROUNDS = 4
FOREVER_S = 1e9
MOST_ALIKE = 0.9
LEAST_WEIGHT = 1e-9
"""Of what sizes say of a rate, over the most: less is nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class Drift:
    """What sizes say of the rates at which a ball's distance grows, and of the perspective.

    Attributes
    ----------
    weights, target
        `weights @ told` is `target`, with errors of 1 each; shapes (M, B + 2) and (M,). What is
        told are the rates of the flights before the first and after each of B bounces, in distances
        a second, and the perspective, 1/px.
    """

    weights: Floats
    target: Floats

    def of_all_flights(self, sigma: float) -> float:
        """Return how large the drift is, as one rate for all flights, root mean square.

        Parameters
        ----------
        sigma
            Standard error of that rate before sizes are known, distances of the camera a second.
        """
        rate, precision = self._as_one()
        both = precision + sigma**-2
        return float(np.hypot(rate * precision / both, both**-0.5))

    def one_rate(self) -> tuple[float, float]:
        """Return the drift as one rate for all flights, by sizes alone, and its standard error."""
        rate, precision = self._as_one()
        return rate, precision**-0.5 if precision > 0.0 else np.inf

    def _as_one(self) -> tuple[float, float]:
        """Return the same and the inverse square of the error; 0 and 0 where sizes say nothing."""
        own = self.weights[:, :-1].sum(axis=1)
        # The perspective is not known here: its part of the equations is taken out.
        other = self.weights[:, -1]
        share = float(other @ other)
        if share > 0.0:
            own = own - other * float(other @ own) / share
        precision = float(own @ own)
        return (float(own @ self.target) / precision if precision > 0.0 else 0.0), precision


def drift(observed: Observed, bounces_s: Floats, clear: NDArray[np.bool_], known: Known) -> Drift:
    """Return what a ball's sizes say of its drift away from the camera.

    Parameters
    ----------
    observed
        Sizes with stated errors; their scatter, and what neighbours have in common, enlarge them.
    bounces_s
        Times of the bounces, s, shape (B,).
    clear
        Which frames count, shape (N,): near the plate a ball lies over its shadow.
    known
        The ball's radius, and whether its film is compressed.
    """
    told = len(bounces_s) + 2
    nothing = Drift(np.zeros((0, told)), np.zeros(0))
    if observed.sizes is None:
        return nothing
    shown = clear & np.isfinite(observed.sizes).all(axis=1)
    if shown.sum() < LEAST_FRAMES:
        return nothing
    larger, sigmas = observed.sizes[shown].T
    # A ball that comes near grows the faster, at a distance that changes evenly.
    sizes, sigmas = 1.0 - 1.0 / (1.0 + larger), sigmas / (1.0 + larger) ** 2
    radius = known.radius_px
    design = _design(observed.times_s[shown], observed.places[shown] / radius, bounces_s)
    beside = np.zeros(design.shape[1])
    beside[-3:-1] = LIGHT_SIGMA**-2
    beside[-1] = (CODEC_PX / radius if known.view.compressed else NOTHING) ** -2
    used = np.ones(len(sizes), dtype=bool)
    enlarge, own = 1.0, sigmas
    for _ in range(ROUNDS):
        own = sigmas * enlarge
        rows = design[used] / own[used, None]
        normal = rows.T @ rows + np.diag(beside)
        solved = np.linalg.pinv(normal, hermitian=True) @ (rows.T @ (sizes / own)[used])
        off = (sizes - design @ solved) / sigmas
        enlarge = max(1.0, 1.4826 * float(np.median(np.abs(off[used]))))
        used = np.abs(off) < OUTLIER * enlarge
        if used.sum() < LEAST_FRAMES:
            return nothing
    own = sigmas * enlarge * _memory(off[used])
    found = _of_rates(design[used] / own[used, None], (sizes / own)[used], beside, told)
    found.weights[:, -1] *= radius
    return found


def _design(times: Floats, places: Floats, bounces_s: Floats) -> Floats:
    """Return derivatives of sizes to each unknown, shape (N, B + 7).

    The unknowns: the rate of each flight and the perspective of one radius, which are wanted; the
    size itself, what a wide lens adds aslant, what light adds along rows and columns, and what a
    codec adds over the film. Lengths are radii.
    """
    ends = [-FOREVER_S, *bounces_s, FOREVER_S]
    spent = [
        np.clip(times, begin, end) - (begin if k else end)
        for k, (begin, end) in enumerate(pairwise(ends))
    ]
    row, column = (places - places.mean(axis=0)).T
    aslant = row**2 + column**2
    whole = (times - times.mean()) / (times[-1] - times[0])
    alike = np.ones(len(times))
    return np.column_stack([-np.array(spent).T, -row, alike, aslant, row, column, whole])


def _memory(off: Floats) -> float:
    """Return by how much what neighbouring sizes have in common enlarges their errors."""
    alike = float((off[1:] * off[:-1]).mean() / max(float((off**2).mean()), 1e-12))
    alike = min(max(alike, 0.0), MOST_ALIKE)
    return float(np.sqrt((1.0 + alike) / (1.0 - alike)))


def _of_rates(design: Floats, seen: Floats, beside: Floats, told: int) -> Drift:
    """Return what equations of unit errors say of the first unknowns, whatever the others are."""
    normal, right = design.T @ design + np.diag(beside), design.T @ seen
    others = normal[told:, told:]
    across = normal[:told, told:] @ np.linalg.pinv(others, hermitian=True)
    information = normal[:told, :told] - across @ normal[told:, :told]
    said = right[:told] - across @ right[told:]
    sizes, ways = np.linalg.eigh(0.5 * (information + information.T))
    counts = sizes > LEAST_WEIGHT * max(float(sizes.max()), 1e-300)
    roots, ways = np.sqrt(sizes[counts]), ways[:, counts]
    return Drift((ways * roots).T, (ways.T @ said) / roots)
