"""Laws that no catalogue holds, proposed for a campaign: what depends on what."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from analysis.effects.effect import Effect
from analysis.model.data.tables import Data
from analysis.model.proposals.document import confirmation_document
from analysis.model.proposals.effect_file import written
from analysis.model.proposals.proposed import Proposed
from analysis.model.proposals.words import proposal_sentences
from rigctl.api.own_effects import KnownEffects
from rigctl.api.pictured import Pictured
from rigctl.api.progress import stating
from rigctl.api.ranking import ErrorPath
from rigctl.documents import Json
from rigctl.model.known_effects import faults_refused
from rigctl.model.proposing import confirmed, proposed_laws, unwritable
from rigctl.model.proposing import shared_laws as asked_together
from rigctl.model.seen_effects import require_seen

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from rigctl.api.campaign import Campaign


def proposals(campaign: str, data: Data, given: Sequence[Effect], known: KnownEffects) -> Proposals:
    """Propose laws beside effects that are given."""
    with faults_refused(), stating() as report:
        require_seen(data, given, "propose")
        found, document = known.all_in(
            lambda effects: proposed_laws(campaign, data, given, effects, report=report)
        )
    return Proposals(campaign, found, document)


def shared_laws(names: Sequence[str], campaigns: Sequence[Data]) -> Json:
    """Propose what several campaigns ask for together."""
    with stating() as say:
        say("scoring forms in all campaigns")
        return asked_together(list(zip(names, campaigns, strict=True)), ())


class Proposals(Pictured):
    """What is proposed, with an error rate that holds; often nothing.

    Attributes
    ----------
    numbers
        The document of `rigctl model propose --json`.
    """

    def __init__(self, campaign: str, found: Proposed, document: Json) -> None:
        self.campaign, self._found, self.numbers = campaign, found, document

    @property
    def verdict(self) -> str:
        """`proposal`, `effect` where the catalogue holds what is missing, or `none`."""
        return str(self.numbers["verdict"])

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the catalogue's effects beside which the laws are proposed."""
        return self._found.effects

    @property
    def sentences(self) -> list[str]:
        """What was proposed, in words."""
        return proposal_sentences(self.numbers)

    def write(self, folder: str | Path) -> list[Path]:
        """Write each proposal as an effect file, and return the paths.

        Raises
        ------
        StoreError
            The folder cannot be written.
        """
        try:
            return written(Path(folder), self.campaign, self._found)
        except OSError as error:
            raise unwritable(Path(folder), error) from error

    @staticmethod
    def confirm(campaign: Campaign, file: str | Path) -> Json:
        """Test the form of a file on the shots of a campaign that it was not chosen on.

        Returns
        -------
        The document of `rigctl model propose --confirm --json`.

        Raises
        ------
        AnalysisInputError
            The file cannot be used, or too few shots are new to it.
        """
        with faults_refused():
            found = confirmed(campaign.name, campaign._data(), (), Path(file))
        return confirmation_document(campaign.name, found)

    def plot(self) -> Axes:
        """Draw the error on shots left out on the way to the proposals."""
        said = {one.name: " on ".join(one.form.group) for one in self._found.accepted}
        stages = [
            replace(stage, effects=tuple(said.get(name, name) for name in stage.effects))
            for stage in self._found.path
        ]
        return ErrorPath(self.campaign, stages).plot()

    def to_dict(self) -> Json:
        """Return the document of `rigctl model propose --json`."""
        return self.numbers

    def _headline(self) -> str:
        return "\n".join(self.sentences)

    def _columns(self) -> Mapping[str, Sequence[object]]:
        found = self.numbers["proposals"]
        names = ("slot", "argument", "shape", "formula", "p_familywise", "error_after")
        return {name: [one[name] for one in found] for name in names}
