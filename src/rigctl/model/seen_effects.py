"""Effects that tables of contacts can show."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.effects.effect import Effect
from analysis.model.data.stream import CampaignData
from analysis.model.data.tables import ContactTable
from analysis.model.fitting.robust_fit import robust_fit
from analysis.model.rank.ranking import rank
from rigctl.errors import AnalysisInputError


def require_seen(data: CampaignData, effects: Sequence[Effect], part: str) -> None:
    """Refuse an effect on which a table of contacts holds nothing: its value would be arbitrary.

    Parameters
    ----------
    part
        What asks for the effects.

    Raises
    ------
    AnalysisInputError
        The table does not show one of them; poses are never refused.
    EffectFault
        One of the user's own has a fault.
    """
    if not isinstance(data, ContactTable) or not effects:
        return
    base = robust_fit(data)
    for effect in effects:
        candidates = rank(base.data, base.fit, [effect]).candidates
        if candidates and not candidates[0].seen:
            raise AnalysisInputError(
                "this effect cannot be seen in tabulated contacts",
                part=part,
                value=repr(effect.name),
                todo="leave it out, or give poses.csv in place of the table",
            )
