"""A campaign with a fit: its results, and what can be computed from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from analysis.effects.effect import Effect
from analysis.model.data.evidence import Stage, stage_of
from analysis.model.data.poses import PoseData
from analysis.model.data.tables import Data
from analysis.model.fitting.adding import added
from analysis.model.fitting.fit import fit_campaign
from analysis.model.fitting.robust_fit import RobustFit, robust_fit
from analysis.model.plane import impact_plane
from analysis.model.rank.ranking import rank
from analysis.model.structure.structure import structure
from analysis.model.verdict.documents import fit_document
from analysis.quantity import Quantity
from rigctl.api.comparison import Agreement, Structure, agreement_of
from rigctl.api.own_effects import Given, KnownEffects
from rigctl.api.pictured import Pictured
from rigctl.api.ranking import ErrorPath, Ranking
from rigctl.documents import Json
from rigctl.model.headline import headline
from rigctl.model.known_effects import faults_refused
from rigctl.model.seen_effects import require_seen

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Fit(Pictured):
    """The law and the effects that were added, fitted to all shots together.

    Attributes
    ----------
    campaign
        Its name.
    """

    def __init__(
        self, campaign: str, measured: Data, chosen: Sequence[Effect], known: KnownEffects
    ) -> None:
        self.campaign = campaign
        self._measured, self._chosen, self._known = measured, tuple(chosen), known
        with faults_refused():
            require_seen(measured, self._chosen, "fit")
            self._robust: RobustFit = robust_fit(measured, self._chosen)

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the effects that were added."""
        return tuple(effect.name for effect in self._chosen)

    @property
    def parameters(self) -> Mapping[str, Quantity]:
        """Values with standard errors and units: of the law first, then of the effects."""
        return self._robust.fit.parameters()

    @property
    def chi2_per_dof(self) -> float:
        """Chi-squared per degree of freedom: 1 when nothing is missing and the errors are true."""
        return self._robust.fit.chi2_per_dof

    @property
    def rejected(self) -> list[int]:
        """Numbers of the shots that were left out, unlike all others or not to be fitted."""
        return self._robust.rejected

    def add(self, *effects: Given) -> Fit:
        """Return a fit with more effects: names, files of one's own, or effects themselves.

        Raises
        ------
        AnalysisInputError
            One has a fault, or cannot be seen in the campaign's tables.
        NotFoundError
            None has that name.
        """
        more = [self._known.chosen(effect) for effect in effects]
        return Fit(self.campaign, self._measured, [*self._chosen, *more], self._known)

    def rank(self) -> Ranking:
        """Score what else the data ask for, the most promising first."""
        ranked = self._known.all_in(lambda left: rank(self._robust.data, self._robust.fit, left))
        return Ranking(self.campaign, ranked)

    def error_path(self) -> ErrorPath:
        """Return the error on shots left out with one effect after the other added.

        All with the shots, frames and noise of this fit.
        """
        with faults_refused():
            return ErrorPath(self.campaign, self._stages())

    def agreement(self) -> Agreement:
        """Hold the fit against the campaign, by stage and quantity."""
        with faults_refused():
            return agreement_of(self.campaign, self._robust.data, self._robust.fit)

    def structure(self) -> Structure:
        """Test what the fit leaves over: each quantity against all that it may depend on."""
        with faults_refused():
            return Structure(self.campaign, structure(self._robust.data, self._robust.fit))

    def plot(self) -> Axes:
        """Draw figure 7.4: the rebound of the surface velocity beside this fit's lines."""
        from analysis.figures.plane import plane_figure  # noqa: PLC0415 - Matplotlib is slow

        plane = impact_plane(self._robust.data, self._robust.fit)
        return plane_figure(f"{self.campaign}: rebound of the surface velocity", plane).axes[0]

    def to_dict(self) -> Json:
        """Return the document of `rigctl model fit --json`."""
        return fit_document(self.campaign, self.effects, self._robust)

    def _stages(self) -> list[Stage]:
        data, last = self._robust.data, self._robust.fit
        if not self._chosen:
            return [stage_of(data, last)]
        data = replace(data, jitter_s=0.0) if isinstance(data, PoseData) else data
        fit = fit_campaign(data)
        stages = [stage_of(data, fit)]
        for effect in self._chosen[:-1]:
            data, fit = added(data, fit, effect)
            stages.append(stage_of(data, fit))
        return [*stages, stage_of(self._robust.data, last)]

    def _headline(self) -> str:
        return headline(" + ".join([self.campaign, *self.effects]), self._robust)

    def _columns(self) -> Mapping[str, list[object]]:
        quantities = self.parameters
        return {
            "parameter": list(quantities),
            "value": [quantity.value for quantity in quantities.values()],
            "sigma": [quantity.sigma for quantity in quantities.values()],
            "unit": [quantity.unit for quantity in quantities.values()],
        }
