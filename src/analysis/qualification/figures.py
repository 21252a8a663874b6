"""Figures 4.1, 4.2, 6.1, 6.2 and table 3.3 of the thesis as our runs draw them, and its numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from analysis.figures.palette import FAILS, FLOOR, GREY, MEASURED, SPHERE_B
from analysis.figures.sheet import plain, sheet
from analysis.qualification.depth import QUANTITIES, BothWays
from analysis.qualification.disk import Turn
from analysis.qualification.drop import Gravity, Method
from analysis.qualification.locating import Way
from analysis.qualification.stage import StageErrors

INCH_M = 0.0254

DROPS_IN_PER_S2 = (384.8, 383.9, 384.6, 384.5, 382.9, 385.4, 383.8, 383.7, 385.7, 385.4)
"""Table 6.1."""
LOCAL_GRAVITY_IN_PER_S2 = 385.92
"""Normal gravity at 40.74 degrees north; the thesis divides by 386.4."""

ANGLES_DEG = (5.982, 11.964, 17.946, 23.928, 29.910, 35.892, 41.874)
COMPUTED_DEG = (5.993, 11.974, 17.973, 23.961, 29.965, 35.938, 41.866)
DEVIATIONS_DEG = (0.221, 0.262, 0.272, 0.202, 0.232, 0.245, 0.247)
"""Table 6.2; the last computed angle is from its relative error."""

MEASURED_Z_IN_PER_S = {"v_n": -68.330, "v_n_after": 48.052, "v_s": 170.586, "v_s_after": 149.526}
CONSTANT_Z_IN_PER_S = {"v_n": -68.588, "v_n_after": 47.824, "v_s": 170.679, "v_s_after": 149.608}
"""Table 3.3; the signs of its printed errors are mixed."""

STAGE_PX = 0.25
"""Accuracy that section 4.2 states for Canny's edges with shell clustering."""


def drop_mean_and_deviation() -> tuple[float, float]:
    """Return mean and standard deviation of table 6.1, m/s^2."""
    values = INCH_M * np.array(DROPS_IN_PER_S2)
    return float(values.mean()), float(values.std(ddof=1))


def z_errors() -> dict[str, float]:
    """Return (constant - measured) / measured of table 3.3, and of the e it implies.

    That of v_s_after over v_s, as ours.
    """
    with_z, without = MEASURED_Z_IN_PER_S, CONSTANT_Z_IN_PER_S
    errors = {name: without[name] / with_z[name] - 1.0 for name in ("v_n", "v_n_after", "v_s")}
    errors["v_s_after"] = (without["v_s_after"] - with_z["v_s_after"]) / with_z["v_s"]
    errors["e"] = (1.0 + errors["v_n_after"]) / (1.0 + errors["v_n"]) - 1.0
    return errors


NAMED: dict[Method, str] = {"thesis": "ours, thesis method", "photometric": "ours, photometric"}
COLOURS: dict[Method, str] = {"thesis": SPHERE_B, "photometric": MEASURED}
DRAWN: dict[Way, tuple[str, str, str]] = {
    "pixel": ("edges at pixels", GREY, "s"),
    "quarters": ("edges at 1/4 px", SPHERE_B, "^"),
    "aht": ("adaptive Hough", FAILS, "D"),
    "photometric": ("grey levels", MEASURED, "o"),
}
NAMES = {"v_n": "$v_n$", "v_n_after": "$v_n'$", "v_s": "$v_s$", "v_s_after": "$v_s'$", "e": "$e$"}
BESIDE = 0.22
"""Between two methods at one place."""


def stage_figure(results: Sequence[StageErrors]) -> Figure:
    """Draw displacements and their errors along each direction, the main ways side by side."""
    moved = results[0].moved_px[:, results[0].along]
    steps = len(moved) - 1
    note = (
        f"A sphere moved by {steps} steps of {np.ptp(moved, axis=0).max() / steps:.3g} px, "
        "displacements about "
        "their mean. Above: measured against true\n(line). Below: errors. Edges: LoG of width 2, "
        "fuzzy shells; the Hough transform takes the edges at 1/4 px (figs. 4.1, 4.2)."
    )
    figure = sheet(10.6, 6.0, "Stage: displacement of a sphere", note)
    directions = list(dict.fromkeys(result.direction for result in results))
    axes = figure.subplots(2, len(directions), sharex=True, sharey="row", squeeze=False)
    for column, direction in enumerate(directions):
        above, below = axes[0, column], axes[1, column]
        for own in (above, below):
            plain(own, "both")
        above.set_title(f"along {direction}", loc="left", fontsize=10, color=GREY)
        below.set_xlabel("true displacement (px)")
        below.axhline(0.0, color=FLOOR, linewidth=1.4)
        shown = [r for r in results if r.direction == direction and r.way in DRAWN]
        for result in shown:
            name, colour, marker = DRAWN[result.way]
            true = result.moved_px[:, result.along[-1]]
            measured = result.measured_px[:, result.along[-1]]
            style: dict[str, Any] = {"color": colour, "marker": marker, "markersize": 4.5}
            above.plot(true, measured, linestyle="none", label=name, **style)
            below.plot(true, measured - true, linewidth=1.0, **style)
        above.plot(true, true, color=FLOOR, linewidth=1.4, zorder=1)
    axes[0, 0].set_ylabel("measured (px)")
    axes[1, 0].set_ylabel("error (px)")
    axes[0, 0].legend(frameon=False, fontsize=9, loc="upper left")
    return figure


def drop_figure(results: Mapping[Method, Gravity]) -> Figure:
    """Draw one fall with its parabola, what the parabola leaves, and gravity of every drop."""
    first = next(iter(results.values())).falls[0]
    note = (
        f"A sphere of {2.0 * first.radius_px:.0f} px let go before the camera, one picture every "
        f"{1e3 * float(np.median(np.diff(first.times_s))):.3g} ms. Left: one drop "
        "and its parabola. Right: gravity\nof each drop, the scale taken from the sphere's "
        "diameter; line: the true value. The thesis's drops against 385.92 in/s² (Newark)."
    )
    figure = sheet(10.6, 5.6, "Drop: gravity from a falling sphere", note)
    grid = figure.add_gridspec(2, 2, height_ratios=[2.2, 1.0], width_ratios=[1.0, 1.15])
    fall, rest = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[1, 0])
    drops = figure.add_subplot(grid[:, 1])
    for own in (fall, rest, drops):
        plain(own, "both")
    for method, found in results.items():
        one = found.falls[0]
        smooth = np.polyval(one.parabola, one.times_s)
        style: dict[str, Any] = {"color": COLOURS[method], "marker": "o", "markersize": 4.5}
        rest.plot(1e3 * one.times_s, one.rows_px - smooth, linewidth=1.0, **style)
    first = next(iter(results.values())).falls[0]
    fine = np.linspace(first.times_s[0], first.times_s[-1], 200)
    fall.plot(1e3 * fine, np.polyval(first.parabola, fine), color=FLOOR, linewidth=1.6)
    fall.plot(1e3 * first.times_s, first.rows_px, "o", color=MEASURED, markersize=4.5)
    fall.set_ylabel("row of the centre (px)")
    fall.invert_yaxis()
    rest.axhline(0.0, color=FLOOR, linewidth=1.4)
    rest.set_ylabel("less parabola (px)")
    rest.set_xlabel("time (ms)")
    _gravities(drops, results)
    return figure


def _gravities(axes: Axes, results: Mapping[Method, Gravity]) -> None:
    true = next(iter(results.values())).true / INCH_M
    axes.axhline(true, color=FLOOR, linewidth=1.6)
    axes.plot(
        range(1, len(DROPS_IN_PER_S2) + 1),
        DROPS_IN_PER_S2,
        "x",
        color=GREY,
        label="thesis, table 6.1",
    )
    for method, found in results.items():
        values = found.values / INCH_M
        label = f"{NAMED[method]}: {values.mean():.2f} ± {found.deviation / INCH_M:.2f}"
        places = np.arange(1, len(values) + 1)
        axes.plot(places, values, "o", color=COLOURS[method], markersize=5, label=label)
    axes.set_xlabel("drop")
    axes.set_ylabel("gravity (in/s²)")
    axes.legend(frameon=False, fontsize=9, loc="best")


def disk_figure(results: Mapping[Method, Sequence[Turn]]) -> Figure:
    """Draw measured against actual angles, the errors of their means, and their scatter."""
    turns = next(iter(results.values()))
    note = (
        f"A disk that turns by {turns[0].actual:.3f} degrees a frame; angles between frames one "
        f"to {len(turns)} apart, all pairs.\nBars: standard deviation of a single angle. Crosses: "
        "table 6.2 of the thesis."
    )
    figure = sheet(9.6, 7.0, "Disk: angles of rotation", note)
    above, below, close = figure.subplots(3, 1, sharex=True, height_ratios=[1.0, 1.2, 1.0])
    for axes in (above, below, close):
        plain(axes, "both")
    above.plot([0, 45], [0, 45], color=FLOOR, linewidth=1.4)
    for axes in (below, close):
        axes.axhline(0.0, color=FLOOR, linewidth=1.4)
    above.plot(ANGLES_DEG, COMPUTED_DEG, "x", color=GREY)
    _printed_angles(below)
    for place, (method, turns) in enumerate(results.items(), start=1):
        actual = np.array([turn.actual for turn in turns])
        means = np.array([turn.mean for turn in turns])
        deviations = [turn.deviation for turn in turns]
        style: dict[str, Any] = {"color": COLOURS[method], "markersize": 5.0}
        above.plot(actual, means, "o", **style)
        aside = actual + 2.5 * BESIDE * place
        for axes in (below, close):
            errors = means - actual
            axes.errorbar(aside, errors, yerr=deviations, fmt="o", label=NAMED[method], **style)
    above.set_ylabel("measured (degrees)")
    below.set_ylabel("error (degrees)")
    close.set_ylabel("ours, closer")
    close.set_xlabel("actual angle (degrees)")
    below.set_ylim(-0.45, 0.33)
    below.legend(frameon=False, fontsize=9, loc="lower left", ncols=3)
    return figure


def _printed_angles(axes: Axes) -> None:
    printed = np.array(COMPUTED_DEG) - np.array(ANGLES_DEG)
    style: dict[str, Any] = {"fmt": "x", "color": GREY, "elinewidth": 0.9}
    axes.errorbar(ANGLES_DEG, printed, yerr=DEVIATIONS_DEG, label="thesis, table 6.2", **style)


def depth_figure(results: Mapping[Method, Sequence[BothWays]]) -> Figure:
    """Draw by how much a constant Z changes each velocity of each shot."""
    note = (
        "Shots measured with the mirror and from the front view alone: (constant − measured) / "
        "measured,\nof $v_s'$ over $v_s$. Crosses: table 3.3 of the thesis, one shot."
    )
    figure = sheet(7.6, 4.8, "Depth: Z constant against Z measured", note)
    axes = figure.add_subplot()
    plain(axes)
    axes.axhline(0.0, color=FLOOR, linewidth=1.4)
    for place, (method, shots) in enumerate(results.items()):
        for at, name in enumerate(QUANTITIES):
            errors = 100.0 * np.array([shot.relative(name) for shot in shots])
            aside = np.full(len(errors), at + BESIDE * (place + 0.5))
            label = NAMED[method] if at == 0 else None
            axes.plot(aside, errors, "o", color=COLOURS[method], alpha=0.8, label=label)
    printed = z_errors()
    values = [100.0 * printed[name] for name in QUANTITIES]
    left = np.arange(len(QUANTITIES)) - BESIDE
    axes.plot(left, values, "x", color=GREY, label="thesis, table 3.3")
    axes.set_xticks(range(len(QUANTITIES)), [NAMES[name] for name in QUANTITIES])
    axes.set_ylabel("change (%)")
    axes.legend(frameon=False, fontsize=9)
    return figure
