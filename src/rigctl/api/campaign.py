"""A campaign as Python has it: measured once, then fitted and explained as often as one likes."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

from analysis.model.data.tables import Data
from rigctl.api.fit import Fit
from rigctl.api.measured import Measured, Source
from rigctl.api.own_effects import Given, KnownEffects
from rigctl.api.proposals import Proposals, proposals, shared_laws
from rigctl.api.shots import Shots
from rigctl.api.verdict import Verdict, explained
from rigctl.documents import Json

if TYPE_CHECKING:
    from rigctl.api.comparison import Agreement


class Campaign:
    """The shots of one set-up, opened by `rigctl.open`.

    Attributes
    ----------
    name
        As its files, or the store, have it.
    """

    def __init__(self, source: Source, known: KnownEffects) -> None:
        self._source, self._known = source, known
        self._measured: Measured | None = None

    @cached_property
    def name(self) -> str:
        """As its files, or the store, have it."""
        return self._source.name

    def __repr__(self) -> str:
        """Return the name."""
        return f"<campaign {self.name}>"

    def measure(self, *, workers: int | None = None) -> Shots:
        """Measure the shots; those that were measured before are read from disk.

        All functions below measure by themselves where needed.

        Parameters
        ----------
        workers
            Processes; None: one for each processor.

        Raises
        ------
        AnalysisInputError
            No shot can be measured, or a file cannot be read.
        NotFoundError
            The store has no such campaign.
        """
        if self._measured is None:
            self._measured = self._source.measured(workers)
            return Shots(self.name, self._measured)
        return Shots(self.name, replace(self._measured, now=0))

    def fit(self, *effects: Given) -> Fit:
        """Fit the hard-sphere law and effects: names, files of one's own, or effects themselves.

        Raises
        ------
        AnalysisInputError
            As `measure`, or an effect has a fault or cannot be seen in the campaign's tables.
        NotFoundError
            No effect has that name.
        """
        chosen = [self._known.chosen(effect) for effect in effects]
        return Fit(self.name, self._data(), chosen, self._known)

    def agreement(self) -> Agreement:
        """Hold the hard-sphere law against the campaign: where it fails, and by how much."""
        return self.fit().agreement()

    def explain(self) -> Verdict:
        """Go the whole way by itself: which effect is missing, none, or none that is known."""
        return explained(self.name, self._data(), self._known)

    def propose(self, *effects: Given) -> Proposals:
        """Propose the law that no catalogue holds: what depends on what, and in which shape.

        Parameters
        ----------
        effects
            Known to be there, beside those of the catalogue that are found on the way.

        Raises
        ------
        AnalysisInputError
            As `measure`, or there are too few shots.
        NotFoundError
            No effect has that name.
        """
        chosen = [self._known.chosen(effect) for effect in effects]
        return proposals(self.name, self._data(), chosen, self._known)

    def propose_together(self, *others: Campaign) -> Json:
        """Ask this campaign and others for a law: what they share, and what each has for itself.

        Returns
        -------
        The document of `rigctl model propose --together --json`.

        Raises
        ------
        AnalysisInputError
            As `measure`; a campaign has too few shots, or they share no argument.
        """
        campaigns = (self, *others)
        return shared_laws([one.name for one in campaigns], [one._data() for one in campaigns])

    def _data(self) -> Data:
        self.measure()
        assert self._measured is not None  # noqa: S101 - it is measured now
        return self._measured.data
