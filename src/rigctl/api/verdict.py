"""The verdict on a campaign: a sentence, and its numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from analysis.model.data.tables import Data
from analysis.model.design.undecided import explain_with_next
from analysis.model.verdict.documents import verdict_report
from analysis.model.verdict.selection import Verdict as Found
from analysis.model.verdict.words import doubts, verdict_sentence
from analysis.quantity import Quantity
from analysis.schema.codec import written
from analysis.schema.verdict import VerdictReport
from rigctl.api.own_effects import KnownEffects
from rigctl.api.pictured import Pictured
from rigctl.api.progress import stating
from rigctl.api.ranking import ErrorPath, Ranking
from rigctl.documents import Json

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def explained(campaign: str, data: Data, known: KnownEffects) -> Verdict:
    """Go the whole way to a verdict; choose the shots that would end its doubts."""
    with stating() as report:
        found, following = known.all_in(lambda left: explain_with_next(data, left, report))
    return Verdict(campaign, found, verdict_report(campaign, data, found, following))


class Verdict(Pictured):
    """What is concluded of a campaign.

    Attributes
    ----------
    numbers
        The document of `rigctl model explain --json`.
    """

    def __init__(self, campaign: str, found: Found, report: VerdictReport) -> None:
        self.campaign, self._found, self._report = campaign, found, report
        self.numbers = written(report)

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
        return verdict_sentence(self._report)

    @property
    def doubts(self) -> list[str]:
        """Open questions of few shots, and implausible results."""
        return doubts(self._report)

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
