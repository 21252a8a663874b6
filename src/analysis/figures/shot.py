"""One shot in one picture: frames with outlines, markers and tracks, and its coefficients."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle as CirclePatch
from matplotlib.patheffects import withStroke

from analysis.arrays import Grey
from analysis.figures.palette import FAILS, GREY, SPHERES
from analysis.imaging.views import View
from analysis.quantity import Quantity
from analysis.shot import MeasuredShot

FRAMES_EACH_SIDE = 3
BRIGHTEST_PERCENTILE = 99.8


def draw_shot(path: Path, title: str, frames: Grey, shot: MeasuredShot) -> None:
    """Write the picture of a measured shot as PNG (as figures 7.2 and 7.3 of the thesis).

    Six frames about the contact with outlines and matched markers; the whole way of both spheres
    over the frame nearest the contact, with the normal; the numbers.
    """
    figure = Figure(figsize=(13.2, 7.6), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(title, x=0.01, ha="left", fontsize=14, fontweight="bold")
    grid = figure.add_gridspec(3, 4, width_ratios=[1, 1, 1, 1.75])
    white = float(np.percentile(frames, BRIGHTEST_PERCENTILE))
    for panel, k in enumerate(_shown(shot)):
        axes = figure.add_subplot(grid[panel // 3, panel % 3])
        _frame(axes, frames[k], white)
        _overlay(axes, shot, k)
        after = 1e3 * (shot.times_s[k] - shot.times_s[0] - shot.impact.contact_time.value)
        axes.set_title(f"frame {k},  {after:+.2f} ms", fontsize=9, loc="left", color=GREY)
    _tracks(figure.add_subplot(grid[:2, 3]), frames, white, shot)
    _speeds(figure.add_subplot(grid[2, :3]), shot)
    _numbers(figure.add_subplot(grid[2, 3]), shot)
    figure.savefig(path)


def _shown(shot: MeasuredShot) -> list[int]:
    before = [shot.used_before[i] for i in _spread(len(shot.used_before))]
    after = [shot.used_after[i] for i in _spread(len(shot.used_after))]
    return before + after


def _spread(count: int) -> list[int]:
    return [int(i) for i in np.linspace(0, count - 1, FRAMES_EACH_SIDE).round()]


def _frame(axes: Axes, frame: Grey, white: float) -> None:
    axes.imshow(frame, cmap="gray", vmin=0, vmax=white, interpolation="nearest")
    axes.set_xlim(-0.5, frame.shape[1] - 0.5)
    axes.set_ylim(frame.shape[0] - 0.5, -0.5)
    axes.set_xticks([])
    axes.set_yticks([])


def _overlay(axes: Axes, shot: MeasuredShot, k: int) -> None:
    for i, colour in enumerate(SPHERES):
        for track in shot.tracking.spheres[i].values():
            if (outline := track.outlines.get(k)) is not None:
                circle = outline.circle
                place = (circle.column, circle.row)
                axes.add_patch(
                    CirclePatch(place, circle.radius, fill=False, color=colour, linewidth=1.2)
                )
                axes.plot(*place, "+", color=colour, markersize=6)
        seen = shot.tracking.markers[i].get(k)
        if seen is None:
            continue
        turned = shot.orientations[i]
        index = np.flatnonzero(turned.frames == k)
        names = turned.matches[int(index[0])] if index.size else np.full(len(seen), -1)
        for (row, column), name in zip(seen.ellipses[:, :2], names, strict=True):
            axes.plot(column, row, ".", color=colour, markersize=4)
            if name >= 0:
                axes.annotate(
                    str(name),
                    (column, row),
                    xytext=(2.5, 2.5),
                    textcoords="offset points",
                    fontsize=7,
                    color="white",
                    path_effects=[withStroke(linewidth=1.6, foreground="black")],
                )


def _tracks(axes: Axes, frames: Grey, white: float, shot: MeasuredShot) -> None:
    nearest = int(np.abs(shot.times_s - shot.times_s[0] - shot.impact.contact_time.value).argmin())
    _frame(axes, frames[nearest], white)
    for i, colour in enumerate(SPHERES):
        for track in shot.tracking.spheres[i].values():
            at = np.array([track.centre(k) for k in sorted(track.outlines)])
            axes.plot(at[:, 1], at[:, 0], ".-", color=colour, markersize=4, linewidth=0.8)
    centres = [
        np.array(shot.tracking.spheres[i][View.FRONT].centre(nearest) or (np.nan, np.nan))
        for i in (0, 1)
    ]
    middle = (centres[0] + centres[1]) / 2
    normal = shot.impact.normal[:2] * 30.0
    axes.annotate(
        "",
        xy=(middle[1] + normal[1], middle[0] + normal[0]),
        xytext=(middle[1], middle[0]),
        arrowprops={"arrowstyle": "->", "color": FAILS, "linewidth": 1.8},
    )
    axes.set_title("tracks in both views, and the normal", fontsize=10, loc="left")


def _speeds(axes: Axes, shot: MeasuredShot) -> None:
    """Draw the horizontal coordinate of both centres against time, with the fitted paths."""
    start, contact = shot.times_s[0], shot.impact.contact_time.value
    impact = shot.impact
    for i, (colour, name) in enumerate(zip(SPHERES, "ab", strict=True)):
        centres = shot.centres[i]
        time = 1e3 * (shot.times_s[centres.frames] - start)
        axes.plot(time, 1e3 * centres.position[:, 1], ".", color=colour, label=f"sphere {name}")
        at = np.interp(contact, shot.times_s[centres.frames] - start, centres.position[:, 1])
        before = (impact.before.velocity_a, impact.before.velocity_b)[i][1]
        after = (impact.after.velocity_a, impact.after.velocity_b)[i][1]
        near = shot.times_s[list(shot.used_before)[-1]] - start
        at = np.interp(near, shot.times_s[centres.frames] - start, centres.position[:, 1])
        at += before * (contact - near)
        for speed, sign in ((before, -1.0), (after, 1.0)):
            reach = np.array([0.0, 4e-3]) * sign
            axes.plot(1e3 * (contact + reach), 1e3 * (at + speed * reach), "-", color=colour)
    axes.axvline(1e3 * contact, color=FAILS, linewidth=1)
    axes.set_xlabel("time from the first frame, ms")
    axes.set_ylabel("Y, mm")
    # Below the plot: any place inside it is on the way of some shot.
    axes.legend(frameon=False, fontsize=8, ncols=2, loc="upper right", bbox_to_anchor=(1.0, -0.12))
    axes.spines[["top", "right"]].set_visible(False)


def _numbers(axes: Axes, shot: MeasuredShot) -> None:
    axes.axis("off")
    impact = shot.impact
    rows: list[tuple[str, Quantity | None]] = [
        ("contact", impact.contact_time.rescaled(1e3, "ms")),
        ("v_n", impact.v_n),
        ("v_s", impact.v_s),
        ("v_n'", impact.v_n_after),
        ("v_s'", impact.v_s_after),
        ("e", impact.e),
        ("beta", impact.beta),
        ("lasts", None if impact.duration is None else impact.duration.rescaled(1e6, "us")),
    ]
    for line, (name, quantity) in enumerate(rows):
        height = 0.97 - 0.125 * line
        axes.text(0.04, height, name, fontsize=11, va="top")
        if quantity is None:
            why = "not told" if name == "lasts" else "v_s is not told from zero"
            axes.text(0.5, height, why, fontsize=11, va="top", color=GREY)
            continue
        unit = "" if quantity.unit == "1" else f" {quantity.unit}"
        # Microseconds of a contact are known to some few of them.
        places = 1 if name == "lasts" else 4
        value, sigma = f"{quantity.value:.{places}f}", f"± {quantity.sigma:.{places}f}{unit}"
        axes.text(0.5, height, value, fontsize=11, va="top", ha="right")
        axes.text(0.54, height, sigma, fontsize=11, va="top", color=GREY)
