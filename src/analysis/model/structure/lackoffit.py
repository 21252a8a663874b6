"""Structure that is left when the model has done what it can: the omnibus alarm and the heat map.

A cell is a channel (what is disturbed) against a covariate (what it may depend on), as five smooth
functions of that covariate. The first of them is a constant, the same in all cells of a channel: it
is tested by itself, so that the course of a cell, what the other four add to it, says what the
channel follows. Each shot's own numbers and everything fitted are projected out, so a
cell's chi-squared has its stated degrees of freedom when nothing is missing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis import chi_squared
from analysis.arrays import Floats
from analysis.model.data.stream import CampaignData
from analysis.model.data.tables import ContactTable
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.fitting.noise import rescaled
from analysis.model.fitting.normal import inverse, with_prior
from analysis.model.predict.theory import Theory
from analysis.model.rank.projector import ColumnSums, Solved
from analysis.model.structure.summing import Name, Summed, summed
from analysis.setup import NO_SLOW_ERRORS, SlowErrors

OWN_CELLS = 4
"""So many cells are an effect's own: few, so that little is paid for looking."""


def own_cells(theory: Theory, sums: Summed) -> Mapping[str, list[Name]]:
    """Return in which cells each effect of a fit shows most, by its name.

    An effect that is really there leaves nothing in these. One that only stands for something else
    mends them in part, and what it leaves stays there.
    """
    chosen: dict[str, list[Name]] = {}
    start = theory.given
    for active in theory.active:
        stop = start + len(active.values)
        shown = _shown(sums, np.arange(start, stop), active.values - active.effect.off)
        chosen[active.effect.name] = sorted(shown, key=lambda name: -shown[name])[:OWN_CELLS]
        start = stop
    return chosen


def _shown(sums: Summed, own: NDArray[np.intp], shift: Floats) -> dict[Name, float]:
    """Return the fall that each cell would bring in a fit without an effect, free of noise.

    What is left there is what the effect does, less what the other parameters can imitate.

    Parameters
    ----------
    own
        Where the effect's parameters stand among the shared ones, shape (B,).
    shift
        Their values, less those where the effect is off, shape (B,).
    """
    others = np.setdiff1d(np.arange(len(sums.known)), own)
    known, information = sums.known[others], sums.information[np.ix_(others, others)]
    covariance = inverse(with_prior(information, known))
    imitated = covariance @ (sums.information[np.ix_(others, own)] @ shift)

    def without(cell: ColumnSums) -> ColumnSums:
        left = cell.against[:, others]
        return replace(cell, against=left, gradient=cell.against[:, own] @ shift - left @ imitated)

    nothing = np.zeros(len(others))
    return {
        name: without(cell).solved(covariance, nothing).chi2 for name, cell in sums.cells.items()
    }


LEAST_ON_A_LINE = 3
OWN_PENALTY = 3.0
"""An effect's own cells have a chance to alarm for each effect accepted: it is a third of the
level, so that true effects with company are not called unexplained more often than nothing is."""


SURE_MEAN = 0.01
"""Chance of a channel's mean, with all channels looked at, below which it is there for sure."""


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
    mean_chi2, mean_freedom
        Fall by the mean of the channel's residuals, and 1; 0 and 0 where something fitted takes its
        place. `mean_p_holm` with all channels looked at.
    constant_chi2
        Fall by the constant alone, fitted beside all that was fitted as the five functions are. Of
        jumps it is not the mean's: a law that is fitted beside it can take another place.
    course_p_holm
        Chance of what the other functions add to the constant, with all cells looked at.
    size, stated
        How large the structure of frames is, m or rad root mean square, and how large the stated
        slow errors of the poses let it be. 0 and 0 of jumps at contact, and where none are stated.
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
    mean_chi2: float = 0.0
    mean_freedom: int = 0
    mean_p_holm: float = 1.0
    constant_chi2: float = 0.0
    course_p_holm: float = 1.0
    size: float = 0.0
    stated: float = 0.0

    @property
    def course(self) -> tuple[float, int]:
        """Chi-squared and degrees of freedom without the channel's constant.

        A constant that is there for sure is taken out as it would be fitted. One that is not may
        well be fitted, as restitution that falls with speed looks like it beside a constant one.
        """
        sure = self.mean_p_holm < SURE_MEAN
        taken = self.constant_chi2 if sure else self.mean_chi2
        return max(0.0, self.chi2 - taken), self.freedom - self.mean_freedom

    @property
    def course_deviation(self) -> float:
        """Standard deviations of that, never below zero."""
        return deviate(*self.course)

    @property
    def mean_deviation(self) -> float:
        """By how many standard errors the channel's constant differs from zero."""
        return float(np.sqrt(max(0.0, self.mean_chi2)))

    @property
    def of_measurement(self) -> bool:
        """Whether it is no larger than what the measurement itself leaves."""
        return self.size < self.stated


def lack_of_fit(data: CampaignData, fit: Fit) -> tuple[Cell, ...]:
    """Test every cell; the most striking first.

    The noise of positions and that of orientations are taken as large as the residuals say, each
    by itself: one scale for both, where the stated ones are wrong in different ways, alarms.
    """
    return cells_of(*noise_matched(data, fit))


def noise_matched(data: CampaignData, fit: Fit) -> tuple[CampaignData, Fit]:
    """Return the data with sigmas as large as the residuals say, and their fit."""
    data = rescaled(data, fit)
    return data, fit_campaign(data, fit.theory, fit)


@dataclass(frozen=True, slots=True, eq=False)
class Tested:
    """All cells, the most striking first, what they are made of, and each one's solution."""

    cells: tuple[Cell, ...]
    sums: Summed
    solved: Mapping[Name, Solved]


def cells_of(data: CampaignData, fit: Fit) -> tuple[Cell, ...]:
    """Test every cell of a fit whose sigmas are true; the most striking first."""
    return tested(data, fit).cells


def tested(data: CampaignData, fit: Fit) -> Tested:
    """Test the same and hand out what was found on the way."""
    sums = summed(data, fit)
    covariance = sums.covariance()
    solved = {name: cell.solved(covariance, sums.left) for name, cell in sums.cells.items()}
    carried = sums.carried(solved, covariance)
    cells = _cells(fit, solved, carried, own_cells(fit.theory, sums))
    constants = {
        name: cell.of_first().solved(covariance, sums.left) for name, cell in sums.cells.items()
    }
    means = {name: _mean(sums, name, beside) for name, beside in constants.items()}
    cells = _with_means(cells, means, constants, max(fit.chi2_per_dof, 1e-12))
    slow = NO_SLOW_ERRORS if isinstance(data, ContactTable) else data.slow
    cells = [_sized(cell, sums, solved, slow) for cell in cells]
    return Tested(tuple(sorted(cells, key=lambda c: (c.p_value, -c.chi2))), sums, solved)


def _mean(sums: Summed, name: Name, beside: Solved) -> Solved:
    """Return the constant of a cell's channel as its residuals show it.

    `beside` is the constant fitted beside all that was fitted. Of frames these hold what the poses
    want beside all of it. Of jumps they are what the fit leaves of each shot, and their mean is no
    longer fitted beside a law that could take it.
    """
    if name[0] not in sums.jumps or beside.freedom == 0:
        return beside
    constant = sums.cells[name].of_first()
    own, gradient = float(constant.own[0, 0]), float(constant.gradient[0])
    return replace(beside, chi2=gradient**2 / own)


def _with_means(
    cells: Sequence[Cell],
    means: Mapping[Name, Solved],
    constants: Mapping[Name, Solved],
    scale2: float,
) -> list[Cell]:
    """Split each cell into the mean of its channel and its course, each with its chance."""
    by_channel = {name[0]: one for name, one in means.items()}
    chances = holm(np.array([_chance(one, scale2) for one in by_channel.values()]))
    looked_at = dict(zip(by_channel, chances, strict=True))
    split = [
        replace(
            cell,
            mean_chi2=means[cell.channel, cell.covariate].chi2 / scale2,
            mean_freedom=means[cell.channel, cell.covariate].freedom,
            mean_p_holm=float(looked_at[cell.channel]),
            constant_chi2=constants[cell.channel, cell.covariate].chi2 / scale2,
        )
        for cell in cells
    ]
    courses = holm(np.array([chi_squared.chance_of_more(*cell.course) for cell in split]))
    return [
        replace(cell, course_p_holm=float(chance))
        for cell, chance in zip(split, courses, strict=True)
    ]


def _sized(cell: Cell, sums: Summed, solved: Mapping[Name, Solved], slow: SlowErrors) -> Cell:
    """Give a cell of frames the size of its structure, beside what slow errors may leave."""
    name = cell.channel, cell.covariate
    if name not in sums.lines:
        return cell
    lines = sums.lines[name]
    stated = slow.between_m if lines.unit == "m" else slow.between_rad
    size = crooked(lines.sums, solved[name].amplitudes)
    return replace(cell, size=size, stated=stated)


def crooked(sums: Floats, amplitudes: Floats) -> float:
    """Return how large a disturbance of amplitudes (5,) is, root mean square.

    Less the straight line on each side of the contact, or along the field, that the shots' own
    numbers take up.

    Parameters
    ----------
    sums
        Of `FrameChannel.lines`, shape (2, 7, 7).
    """
    squares = 0.0
    for side in sums:
        if side[0, 0] <= LEAST_ON_A_LINE:
            continue
        met = side[:2, 2:] @ amplitudes
        line = np.linalg.lstsq(side[:2, :2], met, rcond=1e-12)[0]
        squares += max(float(amplitudes @ side[2:, 2:] @ amplitudes - met @ line), 0.0)
    return float(np.sqrt(squares / max(float(sums[:, 0, 0].sum()), 1.0)))


def _cells(
    fit: Fit,
    solved: Mapping[Name, Solved],
    carried: Mapping[Name, float],
    own: Mapping[str, Sequence[Name]],
) -> list[Cell]:
    """Judge every cell, with all of them looked at; `own` are those of each effect of the fit."""
    scale2 = max(fit.chi2_per_dof, 1e-12)
    p_values = np.array([_chance(one, scale2) for one in solved.values()])
    looked_at = holm(p_values)
    theirs = {name for chosen in own.values() for name in chosen}
    few = np.array([k for k, name in enumerate(solved) if name in theirs], dtype=np.intp)
    looked_at[few] = np.minimum(looked_at[few], OWN_PENALTY * holm(p_values[few]))
    return [
        Cell(
            channel=name[0],
            covariate=name[1],
            chi2=one.chi2 / scale2,
            freedom=one.freedom,
            p_value=float(p_values[k]),
            p_holm=float(looked_at[k]),
            carried_share=carried[name],
            p_rest=_chance_of_rest(one, carried[name], scale2, len(solved)),
            own_of=tuple(effect for effect, chosen in own.items() if name in chosen),
        )
        for k, (name, one) in enumerate(solved.items())
    ]


def _chance_of_rest(solved: Solved, carried: float, scale2: float, cells: int) -> float:
    """Return the chance of what a cell's two strongest shots do not carry, of so many cells."""
    rest = 1.0 - carried
    # Two shots carry everything where there are no more.
    return 1.0 if rest <= 0.0 else min(1.0, cells * _chance(solved, scale2 / rest))


def deviate(chi2: float, freedom: int) -> float:
    """Return a chi-squared as a normal deviate, never below zero.

    E. B. Wilson and M. M. Hilferty, Proc. Natl. Acad. Sci. 17, 684 (1931): unlike the p-value it
    does not end at the smallest number.
    """
    if freedom == 0:
        return 0.0
    spread = 2 / (9 * freedom)
    return max(0.0, float((np.cbrt(chi2 / freedom) - (1 - spread)) / spread**0.5))


def _chance(solved: Solved, scale2: float) -> float:
    return float(chi_squared.chance_of_more(solved.chi2 / scale2, solved.freedom))


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
