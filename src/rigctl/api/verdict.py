"""The verdict on a campaign: a sentence, and its numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from analysis.effects.effect import Effect
from analysis.model.data.tables import Data
from analysis.model.design.between import Telling
from analysis.model.design.undecided import next_after
from analysis.model.verdict.report import verdict_document
from analysis.model.verdict.selection import Verdict as Found
from analysis.model.verdict.selection import explain
from analysis.model.verdict.words import doubts, verdict_sentence
from analysis.quantity import Quantity
from rigctl.api.own_effects import KnownEffects
from rigctl.api.pictured import Pictured
from rigctl.api.progress import stating
from rigctl.api.ranking import ErrorPath, Ranking
from rigctl.documents import Json

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def explained(campaign: str, data: Data, known: KnownEffects) -> Verdict:
    """Go the whole way to a verdict; choose the shots that would end its doubts."""

    def explained(effects: Sequence[Effect]) -> tuple[Found, Telling | None]:
        found = explain(data, effects, report)
        report("choosing shots")
        return found, next_after(found, effects)

    with stating() as report:
        found, following = known.all_in(explained)
    return Verdict(campaign, found, verdict_document(campaign, data, found, following))


class Verdict(Pictured):
    """What is concluded of a campaign.

    Attributes
    ----------
    numbers
        The document of `rigctl model explain --json`.
    """

    def __init__(self, campaign: str, found: Found, document: Json) -> None:
        self.campaign, self._found, self.numbers = campaign, found, document

    @property
    def verdict(self) -> str:
        """`none`, `effect`, `alias` or `unexplained`."""
        return self._found.verdict

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the effects that were found."""
        return self._found.effects

    @property
    def sentence(self) -> str:
        """The verdict in words."""
        return verdict_sentence(self.numbers)

    @property
    def doubts(self) -> list[str]:
        """Open questions of few shots, and implausible results."""
        return doubts(self.numbers)

    @property
    def parameters(self) -> Mapping[str, Quantity]:
        """Values with standard errors and units, with everything found in the fit."""
        return self._found.fit.parameters()

    @property
    def next_shots(self) -> list[Json]:
        """Settings of the shots that would end the doubts; empty where there is none."""
        return list(self.numbers["next_shots"])

    def ranking(self) -> Ranking:
        """Return the ranking before any effect was added."""
        return Ranking(self.campaign, self._found.first_ranking)

    def error_path(self) -> ErrorPath:
        """Return the error on shots left out on the way to the verdict."""
        return ErrorPath(self.campaign, self._found.path)

    def plot(self) -> Axes:
        """Draw the error path."""
        return self.error_path().plot()

    def to_dict(self) -> Json:
        """Return the document of `rigctl model explain --json`."""
        return self.numbers

    def _headline(self) -> str:
        return "\n".join([self.sentence, *self.doubts])

    def _columns(self) -> Mapping[str, list[object]]:
        return self.error_path()._columns()
