"""Campaigns that are measured already: tables in a folder, or a name in the store."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from analysis.campaign import DESCRIPTION
from analysis.exchange.description import read_description
from analysis.model.data.gather import gather
from rigctl.api.measured import Measured
from rigctl.input_errors import in_words


@dataclass(frozen=True, slots=True)
class Tables:
    """An exchange folder with contacts.csv, impacts.csv or poses.csv, or one of these files."""

    path: Path

    @property
    def name(self) -> str:
        """Name of the campaign."""
        folder = self.path.parent if self.path.is_file() else self.path
        with in_words():
            return read_description(folder / DESCRIPTION)[0]

    def measured(self, workers: int | None) -> Measured:
        """Return what the tables hold, of the latest stage that is there."""
        with in_words():
            return Measured(gather(self.path)[1])


@dataclass(frozen=True, slots=True)
class Named:
    """A campaign in the store of a configuration; its daemon measures the shots."""

    name: str
    configuration: Path | None

    def measured(self, workers: int | None) -> Measured:
        """Return the shots that are measured; those that are not are refused by name."""
        # The store needs a system with file locks; folders do not.
        from rigctl.model.campaigns import open_campaign  # noqa: PLC0415

        return Measured(open_campaign(Path(self.name), self.configuration)[1])
