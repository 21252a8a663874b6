"""The residuals behind the heat map: what every shot says to a cell, and how it runs."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.model.data.columns import ORDER
from analysis.model.data.stream import CampaignData, whole
from analysis.model.data.tables import Data
from analysis.model.fitting.fit import Fit
from analysis.model.predict.linear import linearise
from analysis.model.rank.projector import LEAST_INFORMATION, Solved
from analysis.model.structure.channels import FrameChannel, frame_channels
from analysis.model.structure.lackoffit import Cell, noise_matched, tested
from analysis.model.structure.summing import Summed

GRID = 60
WINDOW = 0.08
"""Width of the running mean's Gaussian window, in ranges of the covariate."""
LEAST_WEIGHT = 1e-3
"""Where less than this share of the largest weight lies, no mean is drawn."""


@dataclass(frozen=True, slots=True, eq=False)
class Trend:
    """A running mean and its standard error, all of shape (G,)."""

    place: Floats
    mean: Floats
    sigma: Floats


@dataclass(frozen=True, slots=True, eq=False)
class CellResiduals:
    """The residuals of one cell, K points.

    Attributes
    ----------
    channel, covariate
        Of the cell.
    unit
        Of the residuals: mm/s, rad/s, mm or mrad.
    shots
        Number of each point's shot, shape (K,).
    frames
        Index of its frame in the shot, -1 where a point is the whole shot, shape (K,).
    place, residual, sigma
        Covariate, residual and its standard error, shape (K,).
    trend
        Running mean, each point weighted by its error; of frames the fitted smooth curve.
    """

    channel: str
    covariate: str
    unit: str
    shots: NDArray[np.intp]
    frames: NDArray[np.intp]
    place: Floats
    residual: Floats
    sigma: Floats
    trend: Trend


@dataclass(frozen=True, slots=True, eq=False)
class Structure:
    """All cells of a fit, the most striking first, and what their residuals are drawn from."""

    cells: tuple[Cell, ...]
    data: Data
    covariates: dict[str, Floats]
    jumps: dict[str, tuple[Floats, Floats]]
    channels: tuple[tuple[FrameChannel, Solved], ...]
    whitened: Floats

    def residuals(self, channel: str, covariate: str) -> CellResiduals:
        """Return the residuals of a cell.

        For a jump at contact a point is a shot: the amplitude of the jump that its poses want,
        its own numbers eliminated. For flight and camera a point is a frame: what is left of it,
        which the shot's own numbers have taken their part of, beside the smooth curve that the
        poses want.

        Raises
        ------
        KeyError
            There is no such cell.
        """
        if channel in self.jumps:
            return self._of_shots(channel, covariate)
        for found, curve in self.channels:
            if (found.name, found.covariate) == (channel, covariate):
                return self._of_frames(found, curve)
        raise KeyError(f"no cell of {channel} against {covariate}")

    def always(self, channel: str) -> CellResiduals:
        """Return the residuals of a channel and their mean, those of shots in the order of firing.

        Raises
        ------
        KeyError
            There is no such channel.
        """
        along = [ORDER] if channel in self.jumps else []
        along += [found.covariate for found, _ in self.channels if found.name == channel]
        found = self.residuals(channel, along[0] if along else "")
        weight = 1 / found.sigma**2
        mean, error = float((weight @ found.residual) / weight.sum()), float(weight.sum() ** -0.5)
        ends = np.array([found.place.min(), found.place.max()])
        trend = Trend(ends, np.full(2, mean), np.full(2, error))
        return replace(found, trend=trend)

    def _of_shots(self, channel: str, covariate: str) -> CellResiduals:
        residual, sigma = self.jumps[channel]
        told = np.isfinite(sigma)
        unit, scale = ("rad/s", 1.0) if "spin" in channel else ("mm/s", 1e3)
        place = self.covariates[covariate][told]
        residual, sigma = scale * residual[told], scale * sigma[told]
        return CellResiduals(
            channel=channel,
            covariate=covariate,
            unit=unit,
            shots=self.data.shots[told],
            frames=np.full(int(told.sum()), -1),
            place=place,
            residual=residual,
            sigma=sigma,
            trend=running_mean(place, residual, sigma),
        )

    def _of_frames(self, channel: FrameChannel, curve: Solved) -> CellResiduals:
        column = channel.whitened()
        products = (column * self.whitened.reshape(column.shape)).sum(axis=3)
        squares = (column**2).sum(axis=3)
        if channel.place.shape[2] == 1:
            products, squares = (part.sum(axis=2, keepdims=True) for part in (products, squares))
        shot, frame, _ = used = np.nonzero(squares > 0)
        smooth, place = channel.smooth[used], channel.place[used]
        residual = 1e3 * (products[used] / squares[used] + smooth @ curve.amplitudes)
        spread = np.einsum("ki,ij,kj->k", smooth, curve.covariance, smooth)
        drawn = np.unique(np.searchsorted(np.sort(place), _grid(place)))
        drawn = np.argsort(place)[drawn.clip(max=len(place) - 1)]
        return CellResiduals(
            channel=channel.name,
            covariate=channel.covariate,
            unit="mm" if channel.unit == "m" else "mrad",
            shots=self.data.shots[shot],
            frames=frame,
            place=place,
            residual=residual,
            sigma=1e3 / np.sqrt(squares[used]),
            trend=Trend(
                place[drawn],
                1e3 * (smooth[drawn] @ curve.amplitudes),
                1e3 * np.sqrt(np.maximum(spread[drawn], 0.0)),
            ),
        )


def structure(campaign: CampaignData, fit: Fit) -> Structure:
    """Test every cell as `lack_of_fit` does, and keep the residuals, all in memory."""
    campaign, fit = noise_matched(campaign, fit)
    found = tested(campaign, fit)
    data, states = whole(campaign), fit.states
    channels = frame_channels(data, states, fit.theory, found.sums.reach)
    return Structure(
        cells=found.cells,
        data=data,
        covariates=found.sums.covariates,
        jumps=_amplitudes(found.sums),
        channels=tuple((c, found.solved[c.name, c.covariate]) for c in channels),
        whitened=linearise(data, states, fit.theory).residual,
    )


def running_mean(place: Floats, values: Floats, sigma: Floats) -> Trend:
    """Return the weighted mean in a Gaussian window that runs over 1 to 99 per cent of the places.

    Its error is that of the values' own errors. Where nearly nothing lies in the window, nothing
    is said.
    """
    grid = _grid(place)
    if grid.size == 0:
        return Trend(grid, grid, grid)
    near = np.exp(-0.5 * ((grid[:, None] - place) / (WINDOW * (grid[-1] - grid[0]))) ** 2)
    weight = near / sigma**2
    total = weight.sum(axis=1)
    told = total > LEAST_WEIGHT * total.max()
    mean = (weight[told] @ values) / total[told]
    error = np.sqrt((near[told] * weight[told]).sum(axis=1)) / total[told]
    return Trend(grid[told], mean, error)


def _grid(place: Floats) -> Floats:
    """Return places over 1 to 99 per cent of those given; none where they are all one."""
    low, high = np.quantile(place, [0.01, 0.99]) if place.size else (0.0, 0.0)
    return np.linspace(low, high, GRID) if high - low > 1e-12 else np.zeros(0)


def _amplitudes(sums: Summed) -> dict[str, tuple[Floats, Floats]]:
    """Return each shot's amplitude of every jump and its error, (S,); infinite: not measured."""
    parts = [part.jumps for part in sums.told]
    own = np.concatenate([np.diagonal(part.own, axis1=1, axis2=2) for part in parts])
    raw = np.concatenate([part.raw for part in parts])
    gradient = np.concatenate([part.gradient for part in parts])
    told = own > LEAST_INFORMATION * raw
    safe = np.where(told, own, 1.0)
    sigma = np.where(told, 1 / np.sqrt(safe), np.inf)
    found = np.where(told, gradient / safe, 0.0)
    return {name: (found[:, k], sigma[:, k]) for k, name in enumerate(sums.jumps)}
