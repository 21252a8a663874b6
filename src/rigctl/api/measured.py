"""What a fit is made of, wherever it comes from: the poses of a campaign, or its contacts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

from analysis.model.data.tables import Data


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """Measured shots.

    Attributes
    ----------
    data
        Poses or contacts of the shots that count.
    refused
        Why each other shot was not measured, by its number.
    now
        How many shots were measured now; of the others the results were there.
    """

    data: Data
    refused: Mapping[int, str] = field(default_factory=dict)
    now: int = 0


class Source(Protocol):
    """Where the shots of a campaign come from."""

    @property
    def name(self) -> str:
        """Name of the campaign."""

    def measured(self, workers: int | None) -> Measured:
        """Return the measured shots; measure those that are not.

        Parameters
        ----------
        workers
            Processes; None: one for each processor.

        Raises
        ------
        AnalysisInputError
            No shot can be measured, or a file cannot be read.
        """
