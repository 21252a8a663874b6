"""Models that do not fit: no shots are chosen by them."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from analysis.effects.effect import Effect
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import Fit, beside_field
from analysis.model.rank.ranking import rank
from analysis.model.structure.far_off import is_far_off

STRIKING = 0.01
"""Family-wise chance below which an effect is named as the one to add."""


class MisfitError(Exception):
    """Nothing that shots are to be chosen for fits the campaign.

    Whatever is missing is taken up by any effect in part, so that the one that takes up more leads
    by far and may be wrong.

    Attributes
    ----------
    fit
        The one that comes nearest.
    """

    def __init__(self, fit: Fit) -> None:
        self.fit = fit
        super().__init__(
            f"chi-squared is {fit.chi2_per_dof:.3g} per degree of freedom, where 1 is the noise, "
            "far more than chance explains"
        )


def require_one_that_fits(data: PoseData, fits: Sequence[Fit]) -> None:
    """Refuse fits that all leave more than chance, two of their shots apart.

    Raises
    ------
    MisfitError
        All of them do.
    """
    if all(is_far_off(beside_field(data, fit)) for fit in fits):
        raise MisfitError(min(fits, key=lambda fit: fit.chi2_per_dof))


def to_add_first(
    data: PoseData, fit: Fit, effects: Sequence[Effect], asked: Collection[str] = ()
) -> str | None:
    """Return the name of the effect with the largest expected drop; None where none does.

    A law that takes the operator's place comes before all others, as in a verdict: an effect beside
    a wrong law makes up for it.

    Parameters
    ----------
    asked
        Names of effects that are in question themselves, and are no answer.
    """
    striking = [
        candidate
        for candidate in rank(data, fit, effects).candidates
        if candidate.seen
        and not candidate.of_measurement
        and candidate.p_familywise < STRIKING
        and candidate.effect.name not in asked
    ]
    laws = [candidate for candidate in striking if candidate.law is not None]
    believed = [candidate for candidate in striking if candidate.plausible]
    first = next(iter((*laws, *believed)), None)
    return None if first is None else first.effect.name
