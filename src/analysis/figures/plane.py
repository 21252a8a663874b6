"""Figure 7.4 of the thesis: the rebound of the surface velocity, with Walton's lines and Maw's."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from analysis.arrays import Floats
from analysis.figures.palette import FAILS, FLOOR, GREY, MEASURED
from analysis.figures.sheet import plain, sheet
from analysis.model.plane import Plane

CORNER = 2.4
"""Reach of the left panels, in units of where Walton's two lines meet."""


def plane_figure(title: str, found: Plane) -> Figure:
    """Draw v_s' / |v_n| against v_s / |v_n|, and below it how far the shots lie from Walton's.

    Left the corner of the two lines, right everything.
    """
    note = (
        "Points: shots, with the standard error of their height over the fitted law. Walton's "
        f"lines: e = {found.e:.4f}, μ = {found.mu:.4f}, β₀ = {found.beta0:.3f}\nof this fit. Maw, "
        f"Barber and Fawcett: the same e and μ, Poisson's ratio {found.poisson_ratio:.2f}. Left: "
        "where sticking ends; right: all shots."
    )
    figure = sheet(10.4, 6.4, title, note)
    axes = figure.subplots(2, 2, height_ratios=[2.2, 1.0], sharex="col")
    corner = float(found.law_x[np.argmin(found.walton)])
    whole = float(found.law_x[-1])
    for column, reach in enumerate((min(CORNER * corner, whole), whole)):
        _rebound(axes[0, column], found, reach)
        _less_walton(axes[1, column], found)
        axes[0, column].set_xlim(0.0, reach)
        axes[1, column].set_xlabel("$v_s / |v_n|$ before contact (1)")
    axes[0, 0].set_ylabel("$v_s' / |v_n|$ after contact (1)")
    axes[1, 0].set_ylabel("less Walton (1)")
    axes[0, 0].legend(frameon=False, fontsize=9, loc="upper left")
    return figure


def _rebound(axes: Axes, found: Plane, reach: float) -> None:
    plain(axes, "both")
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    axes.plot(found.law_x, found.walton, color=FAILS, linewidth=1.8, label="Walton, two lines")
    _maw(axes, found, found.maw)
    _shots(axes, found, found.y)
    shown = np.concatenate(
        [found.walton[found.law_x <= reach], found.y[found.x <= reach], np.zeros(1)]
    )
    low, high = float(shown.min()), float(shown.max())
    axes.set_ylim(low - 0.12 * (high - low), high + 0.12 * (high - low))


def _less_walton(axes: Axes, found: Plane) -> None:
    plain(axes, "both")
    rest = found.y - np.interp(found.x, found.law_x, found.walton)
    bend = found.maw - found.walton
    axes.axhline(0.0, color=FAILS, linewidth=1.8)
    _maw(axes, found, bend)
    _shots(axes, found, rest)
    far = 1.15 * max(float(np.abs(rest).max(initial=1e-3)), float(np.abs(bend).max()))
    axes.set_ylim(-far, far)


def _maw(axes: Axes, found: Plane, height: Floats) -> None:
    name = "Maw, Barber and Fawcett"
    axes.plot(found.law_x, height, color=FLOOR, linewidth=1.8, linestyle="--", label=name)


def _shots(axes: Axes, found: Plane, height: Floats) -> None:
    axes.errorbar(
        found.x,
        height,
        yerr=found.sigma,
        fmt="o",
        color=MEASURED,
        markersize=3.6,
        elinewidth=0.8,
        alpha=0.85,
        label="shots",
    )
