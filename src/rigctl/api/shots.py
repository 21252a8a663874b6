"""The measured shots of a campaign: coefficients with their errors, each shot by itself."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING, Literal

import numpy as np

from analysis.model.data.columns import ORDER
from analysis.model.data.poses import PoseData
from analysis.model.data.tables import Data
from analysis.results.campaign import Results, results, unusable_shots
from analysis.results.from_poses import pose_impacts
from analysis.results.from_table import table_impacts
from analysis.results.impacts import Impacts
from analysis.results.lines import TooFewShotsError
from analysis.results.ratios import ratios, velocities
from analysis.results.tables import VELOCITIES
from rigctl.api.columns import Array, Columns, as_table
from rigctl.api.measured import Measured
from rigctl.errors import AnalysisInputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from pandas import DataFrame

Picture = Literal["rebound", "restitution", "residuals"]


class Shots:
    """The measured shots of a campaign.

    Attributes
    ----------
    name
        Of the campaign.
    now
        How many were measured by this call; the others had been before.
    """

    def __init__(self, name: str, measured: Measured) -> None:
        self.name, self.now = name, measured.now
        self._measured = measured

    def __len__(self) -> int:
        """Return how many shots have a measured impact."""
        return len(self._impacts.shots)

    def __repr__(self) -> str:
        """Return what there is."""
        left = f", {len(self.left_out)} left out" if self.left_out else ""
        return f"<{self.name}: {len(self)} measured shots{left}>"

    @property
    def left_out(self) -> Mapping[int, str]:
        """Why each other shot has no coefficients, by its number."""
        data = self._data
        return {
            **dict.fromkeys(data.excluded, "a person excluded it"),
            **{one.shot: one.reason for one in unusable_shots(data, self._impacts)},
            **self._measured.refused,
            **{one.shot: one.reason for one in self._impacts.left_out},
        }

    def table(self) -> DataFrame | Columns:
        """Return one row a shot: settings, velocities (m/s) and coefficients with their sigmas.

        `v_n`, `v_s`, `v_n_after`, `v_s_after`, `e`, `beta` and the ratio of impulses `f`, each with
        `sigma_...`; not a number where it is not measured. Signs as in section 7.1 of the thesis.

        Returns
        -------
        A pandas DataFrame where pandas is installed, its units in `attrs["units"]`; else columns
        by name.
        """
        columns, units = self._columns()
        return as_table(columns, units)

    def plot(self, of: Picture | None = None) -> Axes:
        """Draw the shots with the lines that are fitted to them.

        Parameters
        ----------
        of
            `rebound`: figure 7.4, v_s' / |v_n| against v_s / |v_n|; `restitution`: e against |v_n|;
            `residuals`: how far each shot lies from the lines. None: `rebound`, and `restitution`
            of spheres without markers, whose v_s nobody sees.

        Returns
        -------
        The first axes of the figure; `axes.figure.axes` has all.

        Raises
        ------
        AnalysisInputError
            Too few shots are measured.
        """
        from analysis.results import drawing  # noqa: PLC0415 - Matplotlib is slow to load

        draw = {
            "rebound": drawing.plane_figure,
            "restitution": drawing.restitution_figure,
            "residuals": drawing.residual_figure,
        }
        if of is None:
            of = "rebound" if self._impacts.surface.any() else "restitution"
        return draw[of](self._results).axes[0]

    def _repr_html_(self) -> str:
        return f"<p>{escape(repr(self))}</p>{Columns(*self._columns()).to_html()}"

    @property
    def _data(self) -> Data:
        return self._measured.data

    @cached_property
    def _impacts(self) -> Impacts:
        data, measured = self._data, self._measured.impacts
        if measured is not None:
            return measured
        return pose_impacts(data) if isinstance(data, PoseData) else table_impacts(data)

    @cached_property
    def _results(self) -> Results:
        try:
            return results(self._data, self._measured.impacts)
        except TooFewShotsError as error:
            raise AnalysisInputError(str(error), part=self.name) from error

    def _columns(self) -> tuple[dict[str, Array], dict[str, str]]:
        impacts, data = self._impacts, self._data
        row = {shot: k for k, shot in enumerate(data.shots.tolist())}
        rows = np.array([row.get(shot, -1) for shot in impacts.shots.tolist()], dtype=np.intp)
        columns: dict[str, Array] = {"shot": impacts.shots}
        for name, values in sorted(data.covariates.items()):
            if name != ORDER:
                columns[name] = np.where(rows < 0, np.nan, values[rows])
        each = ratios(impacts)
        quantities = dict(zip(VELOCITIES, velocities(impacts), strict=True))
        quantities |= {"e": each.e, "beta": each.beta, "f": each.f}
        for name, quantity in quantities.items():
            columns |= {name: quantity.value, f"sigma_{name}": quantity.sigma}
        units = {f"{part}{name}": "m/s" for name in VELOCITIES for part in ("", "sigma_")}
        return columns, units
