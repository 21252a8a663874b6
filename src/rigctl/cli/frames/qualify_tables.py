"""Tables and documents of the qualification runs, the thesis's values beside ours."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rich.console import Console
from rich.table import Table

from analysis.qualification.depth import QUANTITIES, BothWays, typical_errors
from analysis.qualification.disk import Turn
from analysis.qualification.drop import Gravity, Method
from analysis.qualification.figures import (
    ANGLES_DEG,
    COMPUTED_DEG,
    DEVIATIONS_DEG,
    DROPS_IN_PER_S2,
    INCH_M,
    LOCAL_GRAVITY_IN_PER_S2,
    STAGE_PX,
    drop_mean_and_deviation,
    z_errors,
)
from analysis.qualification.stage import StageErrors
from rigctl.cli.output import TABLE_WIDTH

Document = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Lines:
    """A table: title, headings, rows, and what stands below."""

    title: str
    headings: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    caption: str


def print_lines(lines: Lines) -> None:
    """Print a table on standard output."""
    table = Table(box=None, padding=(0, 2, 0, 0))
    for place, heading in enumerate(lines.headings):
        table.add_column(heading, justify="right" if place else "left", no_wrap=True)
    for row in lines.rows:
        table.add_row(*row)
    console = Console(highlight=False)
    console.width = max(console.width, TABLE_WIDTH)
    console.print(lines.title, style="bold", markup=False)
    console.print(table)
    console.print(lines.caption, markup=False)


def stage_document(results: Sequence[StageErrors]) -> Document:
    """Return rms and largest error of each way and direction, pixels."""
    return {
        "thesis_px": STAGE_PX,
        "errors": [
            {
                "direction": result.direction,
                "way": result.way,
                "rms_px": result.rms_px,
                "largest_px": result.largest_px,
            }
            for result in results
        ],
    }


def stage_lines(results: Sequence[StageErrors]) -> Lines:
    """Return one row for each way, one pair of columns for each direction."""
    directions = list(dict.fromkeys(result.direction for result in results))
    at = {(result.way, result.direction): result for result in results}
    rows = [
        (way, *(f"{at[way, d].rms_px:.4f} {at[way, d].largest_px:.4f}" for d in directions))
        for way in dict.fromkeys(result.way for result in results)
    ]
    return Lines(
        "stage: errors of displacements in px, root mean square and largest (figs. 4.1, 4.2)",
        ("centre by", *(f"along {direction}" for direction in directions)),
        rows,
        f"thesis: {STAGE_PX} px with Canny's edges, much better with the subpixel technique",
    )


def drop_document(found: Mapping[Method, Gravity]) -> Document:
    """Return gravity, its scatter and its bias, m/s^2 and relative."""
    mean, deviation = drop_mean_and_deviation()
    local = INCH_M * LOCAL_GRAVITY_IN_PER_S2
    return {
        "thesis": _gravity(mean, deviation, mean / local - 1.0, local)
        | {"values_m_per_s2": [INCH_M * value for value in DROPS_IN_PER_S2]},
        "methods": {
            method: _gravity(own.mean, own.deviation, own.bias, own.true)
            | {"values_m_per_s2": own.values.tolist()}
            for method, own in found.items()
        },
    }


def _gravity(mean: float, deviation: float, bias: float, true: float) -> Document:
    known = math.isfinite(deviation)
    return {
        "true_m_per_s2": true,
        "mean_m_per_s2": mean,
        "deviation_m_per_s2": deviation if known else None,
        "bias": bias,
        "scatter": deviation / true if known else None,
    }


def drop_lines(found: Mapping[Method, Gravity]) -> Lines:
    """Return a row for the thesis and for each method."""
    document = drop_document(found)
    series = {"thesis, table 6.1": document["thesis"]} | {
        f"ours, {method}": own for method, own in document["methods"].items()
    }
    rows = [
        (
            name,
            str(len(own["values_m_per_s2"])),
            f"{own['mean_m_per_s2'] / INCH_M:.2f}",
            _told(own["deviation_m_per_s2"], 1.0 / INCH_M, 2),
            f"{100 * own['bias']:+.3f}",
            _told(own["scatter"], 100.0, 3),
        )
        for name, own in series.items()
    ]
    true = next(iter(found.values())).true / INCH_M
    return Lines(
        "drop: gravity from a falling sphere",
        ("", "drops", "mean in/s²", "deviation in/s²", "bias %", "scatter %"),
        rows,
        f"bias of ours against {true:.2f} in/s², of the thesis against {LOCAL_GRAVITY_IN_PER_S2}, "
        "normal gravity at its place",
    )


def _told(value: float | None, factor: float, places: int) -> str:
    """Return a number as text; a single drop has no deviation."""
    return "-" if value is None else f"{factor * value:.{places}f}"


def disk_document(found: Mapping[Method, Sequence[Turn]]) -> Document:
    """Return the angles of table 6.2, degrees."""
    printed = zip(ANGLES_DEG, COMPUTED_DEG, DEVIATIONS_DEG, strict=True)
    return {
        "thesis": [_angle(actual, mean, deviation) for actual, mean, deviation in printed],
        "methods": {
            method: [
                _angle(turn.actual, turn.mean, turn.deviation) | {"pairs": len(turn.angles)}
                for turn in turns
            ]
            for method, turns in found.items()
        },
    }


def _angle(actual: float, mean: float, deviation: float) -> Document:
    return {
        "actual_deg": actual,
        "mean_deg": mean,
        "relative_error": mean / actual - 1.0,
        "deviation_deg": deviation,
    }


def disk_lines(found: Mapping[Method, Sequence[Turn]]) -> Lines:
    """Return a row for each angle: mean, relative error and deviation, thesis first."""
    document = disk_document(found)
    series = [document["thesis"], *document["methods"].values()]
    rows = [
        (
            f"{angles[0]['actual_deg']:.3f}",
            *(
                f"{a['mean_deg']:.3f} {100 * a['relative_error']:+.3f} {a['deviation_deg']:.3f}"
                for a in angles
            ),
        )
        for angles in zip(*series, strict=False)
    ]
    return Lines(
        "disk: mean angle in degrees, its relative error in %, deviation in degrees",
        ("actual", "thesis, table 6.2", *(f"ours, {method}" for method in found)),
        rows,
        "relative error: (measured - actual) / actual, as the table prints it",
    )


def depth_document(method: Method, shots: Sequence[BothWays], refused: Sequence[str]) -> Document:
    """Return relative changes by a constant Z, shot by shot."""
    return {
        "method": method,
        "thesis": z_errors(),
        "shots": [{name: shot.relative(name) for name in QUANTITIES} for shot in shots],
        "refused": list(refused),
    }


def depth_lines(method: Method, shots: Sequence[BothWays], refused: Sequence[str]) -> Lines:
    """Return a row for each quantity: the thesis's one shot, our median and largest."""
    printed, ours = z_errors(), typical_errors(shots)
    rows = [
        (
            name,
            f"{100 * printed[name]:+.2f}",
            f"{100 * ours[name][0]:.2f}",
            f"{100 * ours[name][1]:.2f}",
        )
        for name in QUANTITIES
    ]
    counted = f"{len(shots)} oblique shots by the {method} method"
    return Lines(
        "depth: change by a constant Z over the measured value (of v_s_after over v_s), in %",
        ("", "thesis, table 3.3", "ours, median", "ours, largest"),
        rows,
        "\n".join([counted, *refused]),
    )
