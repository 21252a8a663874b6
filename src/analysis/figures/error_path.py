"""The curve that must fall: the error on shots left out after each effect."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from analysis.figures.palette import FLOOR, MEASURED
from analysis.figures.sheet import plain, sheet
from analysis.model.data.evidence import Stage

BARS = 2.0


def error_path_figure(title: str, path: Sequence[Stage]) -> Figure:
    """Draw the prediction error of each stage of the way to a verdict, with the noise floor."""
    note = (
        "Cross-validation in five parts: poses after contact are predicted from those before, "
        "with\nparameters fitted to the other four. Bars: two standard deviations. "
        "Green: noise alone."
    )
    figure = sheet(max(6.4, 2.4 + 1.6 * len(path)), 4.6, title, note)
    axes = figure.add_subplot()
    plain(axes)
    values = [stage.error.value for stage in path]
    bars = [BARS * stage.error.sampling for stage in path]
    axes.axhline(1.0, color=FLOOR, linewidth=1.6, linestyle="--")
    axes.errorbar(
        range(len(path)),
        values,
        yerr=bars,
        fmt="o-",
        color=MEASURED,
        linewidth=1.8,
        markersize=7,
        capsize=3,
    )
    low = min(1.0, *(value - bar for value, bar in zip(values, bars, strict=True)))
    high = max(1.0, *(value + bar for value, bar in zip(values, bars, strict=True)))
    for k, (value, bar) in enumerate(zip(values, bars, strict=True)):
        # Away from the floor, on whose line it could not be read.
        side = 1 if value >= 1.0 else -1
        axes.annotate(
            f"{value:.3f}",
            (k, value + side * bar),
            xytext=(8, side * 6),
            textcoords="offset points",
            ha="left",
            va="bottom" if side > 0 else "top",
            fontweight="bold",
            fontsize=10,
        )
    axes.set_ylim(low - 0.18 * (high - low), high + 0.18 * (high - low))
    axes.set_xlim(-0.5, max(len(path), 2) - 0.5)
    axes.set_xticks(range(len(path)), _labels(path))
    axes.tick_params(axis="x", length=0)
    # The base model is on the left, its number above the floor.
    axes.text(
        0.005,
        1.0,
        "noise floor",
        transform=axes.get_yaxis_transform(),
        color=FLOOR,
        ha="left",
        va="bottom",
        fontsize=9,
    )
    axes.set_ylabel("prediction error (units of the noise)")
    return figure


def _labels(path: Sequence[Stage]) -> list[str]:
    """Return what each stage added or dropped, one name a line."""
    labels, before = [], None
    for stage in path:
        now = set(stage.effects)
        if before is None:
            changes = [f"+ {name}" for name in stage.effects] or ["base model"]
        else:
            changes = [f"+ {name}" for name in stage.effects if name not in before]
            changes += [f"− {name}" for name in sorted(before - now)]
        labels.append("\n".join(changes))
        before = now
    return labels
