"""Structure that is left when the model has done what it can: the omnibus alarm and the heat map.

A cell is a channel (what is disturbed) against a covariate (what it may depend on), as five smooth
functions of that covariate. Each shot's own numbers and everything fitted are projected out, so a
cell's chi-squared has its stated degrees of freedom when nothing is missing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from analysis import chi_squared
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import CampaignData, whole
from analysis.model.data.tables import Data
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.fitting.noise import rescaled
from analysis.model.rank.projector import ByShot, Projector, Solved, projector
from analysis.model.structure.channels import FrameChannel, contact_columns, frame_channels
from analysis.model.structure.covariates import shot_covariates
from analysis.model.structure.signature import own_cells
from analysis.setup import SlowErrors

Floats = NDArray[np.float64]

SMOOTH = 5
BOTH = float(np.sqrt(2.0))
"""Spheres err each by itself: their difference by so much more."""
OWN_PENALTY = 3.0
"""An effect's own cells have a chance to alarm for each effect accepted: it is a third of the
level, so that true effects with company are not called unexplained more often than nothing is."""


@dataclass(frozen=True, slots=True)
class Cell:
    """One cell of the heat map.

    Attributes
    ----------
    channel, covariate
        What is disturbed, and against what.
    chi2, freedom
        Fall of chi-squared that five smooth functions would bring, in units of the noise found.
    p_value
        By itself; `p_holm` with all cells looked at, or with the few in which the effects of the
        fit show most, whichever is less.
    carried_share
        Share of the fall that is gone without the two shots that speak loudest for it.
    p_rest
        `p_holm` without these two, every cell counted.
    own_of
        Names of the fit's effects that show in this cell most.
    size, stated
        Of structure of frames, m or rad: how large it is, root mean square, and how large the
        stated slow errors of the poses let it be. 0 and 0: of a contact, or where none are stated.
    """

    channel: str
    covariate: str
    chi2: float
    freedom: int
    p_value: float
    p_holm: float
    carried_share: float
    p_rest: float
    own_of: tuple[str, ...] = ()
    size: float = 0.0
    stated: float = 0.0

    @property
    def of_measurement(self) -> bool:
        """Whether it is no larger than what the measurement itself leaves."""
        return self.size < self.stated


def lack_of_fit(data: CampaignData, fit: Fit) -> tuple[Cell, ...]:
    """Test every cell; the most striking first.

    The noise of positions and that of orientations are taken as large as the residuals say, each
    by itself: one scale for both, where the stated ones are wrong in different ways, alarms.
    """
    data, fit = noise_matched(data, fit)
    return cells_of(data, fit, projector(data, fit))


def noise_matched(data: CampaignData, fit: Fit) -> tuple[Data, Fit]:
    """Return the data with sigmas as large as the residuals say, and their fit."""
    data = rescaled(data, fit)
    return whole(data), fit_campaign(data, fit.theory, fit)


@dataclass(frozen=True, slots=True, eq=False)
class Tested:
    """What cells are made of: jumps at contact by shot, and the curves of flight and camera."""

    jumps: dict[str, ByShot]
    curves: tuple[tuple[FrameChannel, Solved], ...]


def cells_of(data: Data, fit: Fit, sums: Projector) -> tuple[Cell, ...]:
    """Test every cell of a fit whose sigmas are true; the most striking first."""
    return tested(data, fit, sums)[0]


def tested(data: Data, fit: Fit, sums: Projector) -> tuple[tuple[Cell, ...], Tested]:
    """Test the same and hand out what was projected on the way."""
    covariates = {name: _basis(values) for name, values in shot_covariates(data, fit).items()}
    contact, whole = contact_columns(data, fit), np.ones((len(data.shots), 1))
    frames = [(channel, channel.columns()) for channel in frame_channels(data, fit)]

    def projected(sums: Projector) -> Tested:
        return Tested(
            {name: sums.project(columns) for name, columns in contact.items()},
            tuple((c, sums.solve(sums.project(columns), whole)) for c, columns in frames),
        )

    def solutions(sums: Projector, parts: Tested) -> list[tuple[str, str, Solved]]:
        found = [
            (name, covariate, sums.solve(by_shot, basis))
            for name, by_shot in parts.jumps.items()
            for covariate, basis in covariates.items()
        ]
        return found + [(c.name, c.covariate, curve) for c, curve in parts.curves]

    def falls(sums: Projector) -> list[tuple[str, str, Solved]]:
        return solutions(sums, projected(sums))

    parts = projected(sums)
    found = solutions(sums, parts)
    cells = _cells(fit, found, own_cells(data, fit, sums, falls))
    if isinstance(data, PoseData):
        cells = _sized(cells, parts.curves, data.slow)
    return tuple(sorted(cells, key=lambda cell: (cell.p_value, -cell.chi2))), parts


def _sized(
    cells: Sequence[Cell], curves: Sequence[tuple[FrameChannel, Solved]], slow: SlowErrors
) -> list[Cell]:
    """Give cells of frames the size of their structure, beside what slow errors may leave."""
    stated = {"m": BOTH * slow.position_m, "rad": BOTH * slow.rotation_rad}
    sizes = {
        (channel.name, channel.covariate): (channel.size(curve.amplitudes), stated[channel.unit])
        for channel, curve in curves
    }
    return [
        replace(cell, size=found[0], stated=found[1])
        if (found := sizes.get((cell.channel, cell.covariate))) is not None
        else cell
        for cell in cells
    ]


def _cells(
    fit: Fit, found: Sequence[tuple[str, str, Solved]], own: Mapping[str, NDArray[np.intp]]
) -> list[Cell]:
    """Judge every cell, with all of them looked at; `own` are those of each effect of the fit."""
    scale2 = max(fit.chi2_per_dof, 1e-12)
    p_values = np.array([_chance(solved, scale2) for *_, solved in found])
    looked_at = holm(p_values)
    few = np.unique(np.concatenate([np.zeros(0, dtype=np.intp), *own.values()]))
    looked_at[few] = np.minimum(looked_at[few], OWN_PENALTY * holm(p_values[few]))
    return [
        Cell(
            channel=channel,
            covariate=covariate,
            chi2=solved.chi2 / scale2,
            freedom=solved.freedom,
            p_value=float(p_values[k]),
            p_holm=float(looked_at[k]),
            carried_share=solved.carried_share,
            p_rest=_chance_of_rest(solved, scale2, len(found)),
            own_of=tuple(name for name, chosen in own.items() if k in chosen),
        )
        for k, (channel, covariate, solved) in enumerate(found)
    ]


def _chance_of_rest(solved: Solved, scale2: float, cells: int) -> float:
    """Return the chance of what a cell's two strongest shots do not carry, of so many cells."""
    rest = 1.0 - solved.carried_share
    # Two shots carry everything where there are no more.
    return 1.0 if rest <= 0.0 else min(1.0, cells * _chance(solved, scale2 / rest))


def standard_deviations(cell: Cell) -> float:
    """Return a cell's chi-squared as a normal deviate, never below zero.

    E. B. Wilson and M. M. Hilferty, Proc. Natl. Acad. Sci. 17, 684 (1931): unlike the p-value it
    does not end at the smallest number.
    """
    if cell.freedom == 0:
        return 0.0
    spread = 2 / (9 * cell.freedom)
    return max(0.0, float((np.cbrt(cell.chi2 / cell.freedom) - (1 - spread)) / spread**0.5))


def _chance(solved: Solved, scale2: float) -> float:
    return float(chi_squared.chance_of_more(solved.chi2 / scale2, solved.freedom))


def _basis(values: Floats) -> Floats:
    """Return five Chebyshev polynomials of a covariate on its 1 to 99 per cent range, (S, 5)."""
    low, high = np.quantile(values, [0.01, 0.99])
    if high - low < 1e-12:
        return np.ones((len(values), 1))
    scaled = np.clip(2 * (values - low) / (high - low) - 1, -1, 1)
    return np.asarray(chebyshev.chebvander(scaled, SMOOTH - 1))


def holm(p_values: Floats) -> Floats:
    """Return p-values with all of them looked at, shape (K,), never above 1.

    S. Holm, Scand. J. Statist. 6, 65 (1979).
    """
    order = np.argsort(p_values)
    factors = len(p_values) - np.arange(len(p_values))
    adjusted = np.minimum(np.maximum.accumulate(p_values[order] * factors), 1.0)
    result = np.empty_like(adjusted)
    result[order] = adjusted
    return result
