"""The figures of a campaign's results: no headings, as the page that holds them has its own."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from analysis.arrays import Floats
from analysis.collision.operator import WaltonLaw
from analysis.effects.contact.tangential_compliance import POISSON_RATIO, maw_curve, walton_curve
from analysis.figures.palette import FAILS, FLOOR, GREY, MEASURED, SPHERE_B
from analysis.figures.sheet import blank, plain
from analysis.results.campaign import Results
from analysis.results.impacts import V_N
from analysis.results.lines import regression_curve
from analysis.results.published import THESIS
from analysis.results.tables import NEAR, corner_of, curve_places

SURE = 0.9
"""Above this probability a shot is drawn as sliding, below one less it as sticking."""
BAND = (1.0, 3.0)
OUT = "#CC79A7"
WORTH_SHOWING = 0.02
"""An error of e with which a shot may widen the axis, however good the others are."""
MOST_DRAWN = 1000
"""More points than this are drawn as an image within the figure: lines would make it heavy."""


def plane_figure(found: Results) -> Figure:
    """Draw figure 7.4: v_s' / |v_n| against v_s / |v_n|; left the corner, right all shots."""
    figure = blank(9.6, 4.3, ConstrainedLayoutEngine())
    axes = figure.subplots(1, 2)
    x = curve_places(found)
    for place, reach in zip(axes, (NEAR * corner_of(found), float(x[-1])), strict=True):
        within = min(reach, float(x[-1]))
        _laws(place, found, x[x <= within * 1.001])
        _shots(place, found)
        _fit_height(place, found, within)
        place.set_xlabel("$v_s / |v_n|$ before contact")
    axes[0].set_ylabel("$v_s$′ / $|v_n|$ after contact")
    axes[1].legend(frameon=False, fontsize=9, loc="upper left")
    return figure


def restitution_figure(found: Results) -> Figure:
    """Draw e against |v_n| (figure 3.1c) with the common e, and the line where it is determined."""
    figure = blank(9.6, 3.4, ConstrainedLayoutEngine())
    axes = figure.subplots()
    plain(axes, "both")
    each, speed = found.ratios.e, found.impacts.approach
    across = np.sqrt(found.impacts.covariance[:, V_N, V_N])
    e = found.coefficients()["e"]
    axes.axhline(e.value, color=FAILS, linewidth=1.6, label=f"all shots, e = {e.concise()}")
    if found.speed is not None:
        grid = np.linspace(speed.min(), speed.max(), 60)
        line, band = found.speed.at(grid), found.speed.sigma_at(grid)
        axes.plot(grid, line, color=FLOOR, linestyle="--", linewidth=1.6, label="line, ± σ")
        axes.fill_between(grid, line - band, line + band, color=FLOOR, alpha=0.18, linewidth=0)
    _points(axes, (speed, across), (each.value, each.sigma), MEASURED, "shots")
    near = each.sigma < max(5 * float(np.median(each.sigma)), WORTH_SHOWING)
    _limit(axes, each.value[near], each.sigma[near])
    axes.set_xlabel("approach speed $|v_n|$, m/s")
    axes.set_ylabel("normal restitution e")
    axes.legend(frameon=False, fontsize=9, loc="best")
    return figure


def residual_figure(found: Results) -> Figure:
    """Draw how far each shot lies from the regression, in its standard errors."""
    figure = blank(9.6, 3.2, ConstrainedLayoutEngine())
    axes = figure.subplots(1, 2, sharey=True)
    held, surface = found.lines.held, np.isfinite(found.lines.held.slides)
    slides = np.nan_to_num(held.slides) > 0.5
    along = np.where(
        slides,
        held.sliding.residual / held.sliding.sigma,
        held.sticking.residual / held.sticking.sigma,
    )
    normal = held.normal_residual / held.normal_sigma
    along = np.where(surface, along, np.nan)
    _pulls(axes[0], found.impacts.approach, normal, found)
    _pulls(axes[1], found.ratios.incidence.value, along, found)
    # Both panels share their heights: the farthest shot of the two is within them.
    shown = np.abs(np.concatenate([normal, along]))
    far = max(3.5, 1.15 * float(np.nanmax(shown, initial=0.0)))
    axes[0].set_ylim(-far, far)
    axes[0].set_xlabel("approach speed $|v_n|$, m/s")
    axes[1].set_xlabel("$v_s / |v_n|$ before contact")
    axes[0].set_ylabel("residual, standard errors")
    axes[0].set_title("$v_n$′ + $e v_n$", fontsize=10, loc="left")
    axes[1].set_title("$v_s$′ less the nearer line", fontsize=10, loc="left")
    return figure


def _laws(axes: Axes, found: Results, x: Floats) -> None:
    plain(axes, "both")
    law, lever = found.lines.law, found.impacts.lever
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    thesis = walton_curve(WaltonLaw(**THESIS), lever, x)
    axes.plot(x, thesis, color=GREY, linewidth=1.2, linestyle=":", label="lines of the thesis")
    if "mu" in found.lines.fitted:
        name = f"Maw, Barber, Fawcett, ν = {POISSON_RATIO:.2f}"
        maw = maw_curve(law.e, law.mu, lever, x)
        axes.plot(x, maw, color=FLOOR, linewidth=1.6, linestyle="--", label=name)
    fitted = regression_curve(found.lines, lever, x)
    if np.isfinite(fitted).any():
        axes.plot(x, fitted, color=FAILS, linewidth=1.6, label="Walton, by regression")


def _shots(axes: Axes, found: Results) -> None:
    slides, each, used = found.lines.held.slides, found.ratios, found.lines.used
    seen = found.impacts.surface
    sticks = used & (slides <= 1 - SURE)
    slid = used & (slides >= SURE)
    kinds = (
        ("sticks", sticks, MEASURED),
        ("slides", slid, SPHERE_B),
        ("either", used & seen & ~sticks & ~slid, GREY),
        ("not in the regression", ~used & seen, OUT),
    )
    for name, chosen, colour in kinds:
        if chosen.any():
            x, y = each.incidence, each.rebound
            across = (x.value[chosen], x.sigma[chosen])
            _points(axes, across, (y.value[chosen], y.sigma[chosen]), colour, f"shot {name}")


def _points(
    axes: Axes, x: tuple[Floats, Floats], y: tuple[Floats, Floats], colour: str, name: str
) -> None:
    axes.errorbar(
        x[0],
        y[0],
        xerr=x[1],
        yerr=y[1],
        fmt="o",
        color=colour,
        markersize=3.8,
        elinewidth=0.8,
        alpha=0.9,
        label=name,
        rasterized=len(x[0]) > MOST_DRAWN,
    )


def _fit_height(axes: Axes, found: Results, reach: float) -> None:
    x = np.linspace(0.0, reach, 50)
    inside = found.ratios.incidence.value <= reach
    law = np.nan_to_num(regression_curve(found.lines, found.impacts.lever, x))
    shown = np.concatenate([found.ratios.rebound.value[inside], law, np.zeros(1)])
    low, high = float(np.nanmin(shown)), float(np.nanmax(shown))
    room = 0.1 * max(high - low, 0.05)
    axes.set_xlim(0.0, reach)
    axes.set_ylim(low - room, high + room)


def _limit(axes: Axes, value: Floats, sigma: Floats) -> None:
    low, high = float((value - sigma).min()), float((value + sigma).max())
    axes.set_ylim(low - 0.15 * (high - low), high + 0.25 * (high - low))


def _pulls(axes: Axes, x: Floats, pulls: Floats, found: Results) -> None:
    plain(axes, "both")
    for width in BAND:
        axes.axhspan(-width, width, color=FLOOR, alpha=0.09, linewidth=0)
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    slides = np.nan_to_num(found.lines.held.slides) > 0.5
    for chosen, colour in ((~slides, MEASURED), (slides, SPHERE_B)):
        axes.plot(
            x[chosen],
            pulls[chosen],
            "o",
            color=colour,
            markersize=3.8,
            alpha=0.9,
            rasterized=len(x) > MOST_DRAWN,
        )
