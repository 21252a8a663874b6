"""All results of a campaign: every shot's coefficients, the two lines, e against speed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from analysis.model.judged import judged
from analysis.model.tables import ContactTable, Data
from analysis.quantity import Quantity
from analysis.results.from_poses import pose_impacts
from analysis.results.from_table import table_impacts
from analysis.results.impacts import Impacts, LeftOut
from analysis.results.lines import Lines, fit_lines
from analysis.results.ratios import Ratios, ratios
from analysis.results.speed import speed_line
from analysis.results.york import Line

NO_BOTH = "no frames show both spheres"
TOO_FAR = "it lies too far from the fit of all shots; look at its frames"


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
        e, mu and beta0 of the hard-sphere operator fitted to all poses, or all tabulated numbers.
    left_out
        Shots that nothing of this uses.
    remarks
        What else was not taken as stated.
    """

    impacts: Impacts
    ratios: Ratios
    lines: Lines
    speed: Line | None
    whole_fit: Mapping[str, Quantity]
    left_out: tuple[LeftOut, ...]
    remarks: tuple[str, ...]


def results(data: Data) -> Results:
    """Measure all impacts of a campaign and fit what they follow.

    Raises
    ------
    TooFewShotsError
        No shot has a measured impact.
    """
    found = judged(data)
    used = found.data
    if isinstance(used, ContactTable):
        impacts = table_impacts(used)
    else:
        impacts = pose_impacts(used, found.fit)
    unusable = set(found.evidence.stated.unusable)
    dropped = [
        LeftOut(number, NO_BOTH if number in unusable else TOO_FAR) for number in found.rejected
    ]
    each = ratios(impacts)
    return Results(
        impacts=impacts,
        ratios=each,
        lines=fit_lines(impacts),
        speed=speed_line(impacts, each),
        whole_fit=found.fit.parameters(),
        left_out=tuple(sorted([*dropped, *impacts.left_out], key=lambda one: one.shot)),
        remarks=tuple(found.remarks()),
    )
