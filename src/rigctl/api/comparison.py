"""Where a fit and its campaign agree, and where they do not."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import TYPE_CHECKING

from analysis.errors import LaunchRefusedError
from analysis.model.agreement.agree import agree
from analysis.model.agreement.document import agreement_document, structure_document
from analysis.model.agreement.launch import launch_stage
from analysis.model.agreement.table import Agreement as Compared
from analysis.model.agreement.table import Stage
from analysis.model.data.stream import CampaignData
from analysis.model.fitting.fit import Fit
from analysis.model.structure.structure import Structure as Tested
from rigctl.api.pictured import Pictured
from rigctl.documents import Json

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def agreement_of(campaign: str, data: CampaignData, fit: Fit) -> Agreement:
    """Compare by stage, the launch first where the settings let it be foretold."""
    launch = list[Stage]()
    with suppress(LaunchRefusedError):
        launch.append(launch_stage(data, fit))
    return Agreement(campaign, agree(data, fit, launch))


class Agreement(Pictured):
    """A fit held against its campaign, line by line."""

    def __init__(self, campaign: str, found: Compared) -> None:
        self.campaign, self._found = campaign, found

    @property
    def prediction_error(self) -> float:
        """Error on shots left out, in units of the noise; noise alone gives 1."""
        return self._found.prediction.value

    def plot(self) -> Axes:
        """Draw the error of each quantity beside its noise, with the numbers."""
        from analysis.figures.agreement import agreement_figure  # noqa: PLC0415 - Matplotlib is slow

        title = f"{self.campaign}: model against measurement"
        return agreement_figure(title, self._found).axes[0]

    def to_dict(self) -> Json:
        """Return the numbers as `rigctl model agreement --json` has them."""
        return agreement_document(self._found)

    def _headline(self) -> str:
        found = self._found.prediction
        return (
            f"{self.campaign}: error on shots left out {found.value:.4f} of the noise "
            f"(floor 1, sampling error {found.sampling:.4f})"
        )

    def _columns(self) -> Mapping[str, list[object]]:
        rows = [(stage.name, row) for stage in self._found.stages for row in stage.rows]
        return {
            "stage": [stage for stage, _ in rows],
            "quantity": [row.quantity for _, row in rows],
            "chi2": [row.chi2 for _, row in rows],
            "degrees_of_freedom": [row.freedom for _, row in rows],
            "p": [row.p_holm for _, row in rows],
            "error_over_noise": [row.error for _, row in rows],
            "error": [row.size for _, row in rows],
            "floor": [row.floor for _, row in rows],
            "unit": [row.unit for _, row in rows],
        }


class Structure(Pictured):
    """What a fit leaves over: cells of one quantity against one covariate, most striking first."""

    def __init__(self, campaign: str, found: Tested) -> None:
        self.campaign, self._found = campaign, found

    def plot(self) -> Axes:
        """Draw all cells as a heat map."""
        from analysis.figures.heatmap import heatmap_figure  # noqa: PLC0415 - Matplotlib is slow

        return heatmap_figure(f"{self.campaign}: where it fails", self._found.cells).axes[0]

    def plot_residuals(self, cell: int = 0) -> Axes:
        """Draw the residuals of each shot behind a cell, counted from the most striking one."""
        from analysis.figures.residuals import residuals_figure  # noqa: PLC0415 - as above

        chosen = self._found.cells[cell]
        points = self._found.residuals(chosen.channel, chosen.covariate)
        return residuals_figure(self.campaign, chosen, points).axes[0]

    def to_dict(self) -> Json:
        """Return the `structure` of `rigctl model agreement --json`."""
        return structure_document(self._found)

    def _headline(self) -> str:
        return f"{self.campaign}: structure that is left"

    def _columns(self) -> Mapping[str, list[object]]:
        cells = self._found.cells
        return {
            "quantity": [cell.channel for cell in cells],
            "against": [cell.covariate for cell in cells],
            "chi2": [cell.chi2 for cell in cells],
            "degrees_of_freedom": [cell.freedom for cell in cells],
            "p": [cell.p_holm for cell in cells],
        }
