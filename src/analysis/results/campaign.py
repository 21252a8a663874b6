"""All results of a campaign: every shot's coefficients, the two lines, e against speed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from analysis.model.data.poses import PoseData
from analysis.model.data.tables import ContactTable, Data
from analysis.model.fitting.robust_fit import Judged, judged
from analysis.quantity import Quantity
from analysis.results.from_poses import pose_impacts
from analysis.results.from_table import table_impacts
from analysis.results.impacts import Impacts, LeftOut
from analysis.results.lasting import contacts_that_last, mean_restitution
from analysis.results.lines import Lines, fit_lines
from analysis.results.ratios import Ratios, ratios
from analysis.results.speed import speed_line
from analysis.results.york import Line

NO_BOTH = "no frames show both spheres"


@dataclass(frozen=True, slots=True, eq=False)
class Results:
    """The thesis's results for a campaign.

    Attributes
    ----------
    impacts, ratios
        What each shot measured, and its coefficients.
    lines
        The regression for e, mu and beta0.
    speed
        e against approach speed; None where the shots do not tell a line.
    whole_fit
        The parameters of the law that was fitted to all poses, or all tabulated numbers: e, mu and
        beta0 of the hard-sphere operator; of contacts that last e, mu and theirs.
    lasting
        Whether the contacts last: the two lines are no law of theirs, and e is the shots' mean.
    left_out
        Shots of which no impact was measured.
    far
        Shots that were measured, and that the regression does not use.
    remarks
        What the fit to all that was measured did not take as stated.
    """

    impacts: Impacts
    ratios: Ratios
    lines: Lines
    speed: Line | None
    whole_fit: Mapping[str, Quantity]
    left_out: tuple[LeftOut, ...]
    far: tuple[LeftOut, ...]
    remarks: tuple[str, ...]
    lasting: bool = False

    def coefficients(self) -> dict[str, Quantity]:
        """Return e, mu and beta0 of the regression, as far as these shots have them."""
        if self.lasting:
            return {"e": mean_restitution(self.impacts, self.lines.used)}
        return self.lines.parameters()


def results(data: Data) -> Results:
    """Measure all impacts of a campaign and fit what they follow.

    Raises
    ------
    TooFewShotsError
        No shot has a measured impact.
    """
    found = judged(data)
    impacts = _impacts(data, found)
    unusable = [LeftOut(number, NO_BOTH) for number in found.evidence.stated.unusable]
    each, lines = ratios(impacts), fit_lines(impacts)
    other = contacts_that_last(found, lines)
    fitted = found if other is None else other
    return Results(
        impacts=impacts,
        ratios=each,
        lines=lines,
        speed=speed_line(impacts, each, lines.used),
        whole_fit=fitted.fit.parameters(),
        left_out=tuple(sorted([*unusable, *impacts.left_out], key=lambda one: one.shot)),
        far=_far(impacts, lines),
        remarks=tuple(fitted.remarks()),
        lasting=other is not None,
    )


def _far(impacts: Impacts, lines: Lines) -> tuple[LeftOut, ...]:
    return tuple(
        LeftOut(
            int(impacts.shots[row]),
            f"measured, but {np.sqrt(lines.held.chi2[row]):.0f} standard errors from both lines: "
            "not in the regression; look for a marker that took another's name",
        )
        for row in np.flatnonzero(~lines.used)
    )


def _impacts(data: Data, found: Judged) -> Impacts:
    """Measure the impacts of all shots, also of those that the fit to all poses leaves out.

    That fit drops shots and frames which are unlike its law; here no law may choose.
    """
    if isinstance(data, PoseData):
        return pose_impacts(data)
    stated = found.evidence.stated
    assert isinstance(stated, ContactTable)  # noqa: S101
    return table_impacts(stated)
