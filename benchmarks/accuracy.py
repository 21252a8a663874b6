"""Measured collisions beside their truth: python benchmarks/accuracy.py FOLDER [FOLDER...].

A folder is an exchange folder with a truth.json. Without one, shots are rendered by the simulators.
Prints a table for each folder, RMS errors beside the goals, and how honest the stated errors are
(pull: error divided by its stated standard error; 1 RMS is right). Writes accuracy.json.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from analysis.campaign import analyse_campaign, read_campaign
from analysis.imaging.edge.frame import EdgeSettings
from analysis.quantity import Quantity
from analysis.shot import AnalysisOptions, MeasuredShot
from simulators.world import write_campaign

GOALS = {"v_n %": 1.0, "e": 0.01, "v_s m/s": 0.08, "contact ms": 0.1}
COLUMNS = ("v_n %", "e", "v_s m/s", "v_s' m/s", "contact ms", "lasts us", "normal deg")


def errors_of(shot: MeasuredShot, truth: dict[str, Any]) -> tuple[list[float], list[float]]:
    """Return the errors in the order of COLUMNS, and the pulls of all but the normal."""
    impact = shot.impact
    angle = np.degrees(np.arccos(min(1.0, float(impact.normal @ np.array(truth["normal"])))))
    if impact.v_s is None or impact.v_s_after is None:
        raise ValueError("too few orientations tell the spins")
    differences = [
        (impact.v_n, truth["v_n"]),
        (impact.e, -truth["v_n_after"] / truth["v_n"]),
        (impact.v_s, truth["v_s"]),
        (impact.v_s_after, truth["v_s_after"]),
        (impact.contact_time, truth["contact_time_s"]),
    ]
    error = [quantity.value - true for quantity, true in differences]
    pulls = [e / quantity.sigma for e, (quantity, _) in zip(error, differences, strict=True)]
    v_n, e, v_s, v_s_after, contact = error
    row = [100 * v_n / truth["v_n"], e, v_s, v_s_after, 1e3 * contact]
    lasts, pull = lasting(impact.duration, truth.get("contact_duration_s"))
    return [*row, 1e6 * lasts, float(angle)], [*pulls, pull]


def lasting(measured: Quantity | None, true: float | None) -> tuple[float, float]:
    """Return error and pull of the contact's duration; not numbers where one is unknown."""
    if measured is None or true is None:
        return np.nan, np.nan
    return measured.value - true, (measured.value - true) / measured.sigma


def compare(folder: Path, options: AnalysisOptions) -> dict[str, Any]:
    """Analyse a folder, print its table, and return the figures."""
    truths = {s["shot"]: s for s in json.loads((folder / "truth.json").read_text())["shots"]}
    campaign = read_campaign(folder)
    print(f"\n{campaign.name}: measured minus truth")
    print("shot  " + "".join(f"{name:>12}" for name in COLUMNS))
    rows, pulls, refused = [], [], []
    for job, shot, _ in analyse_campaign(campaign, options):
        if not isinstance(shot, MeasuredShot):
            refused.append(job.shot)
            print(f"{job.shot:4d}  refused at {shot.step}, frame {shot.frame}: {shot.reason}")
            continue
        row, pull = errors_of(shot, truths[job.shot])
        rows.append(row)
        pulls.append(pull)
        print(f"{job.shot:4d}  " + "".join(f"{value:12.4f}" for value in row))
    rms = dict(zip(COLUMNS, np.sqrt((np.array(rows) ** 2).mean(axis=0)), strict=True))
    pull_rms = np.sqrt((np.array(pulls) ** 2).mean(axis=0))
    print("RMS   " + "".join(f"{rms[name]:12.4f}" for name in COLUMNS))
    print(
        "goal  "
        + "".join(f"{GOALS[name]:12.4f}" if name in GOALS else " " * 12 for name in COLUMNS)
    )
    print("pulls " + "".join(f"{value:12.2f}" for value in pull_rms))
    print(f"analysed {len(rows)}, refused {len(refused)} of {len(campaign.jobs)}")
    return {
        "campaign": campaign.name,
        "analysed": len(rows),
        "refused": refused,
        "rms": {name: float(value) for name, value in rms.items()},
        "pull_rms": dict(zip(COLUMNS[:6], map(float, pull_rms), strict=True)),
    }


def render(folder: Path, shots: int, seed: int) -> Path:
    """Render shots over the whole range of pressures and offsets."""
    spread = np.random.default_rng(seed)
    pressures = spread.uniform(20, 100, shots)
    offsets = spread.uniform(0, 20, shots)
    write_campaign(folder, list(map(float, pressures)), list(map(float, offsets)), seed)
    return folder


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--shots", type=int, default=24, help="rendered shots, without a folder")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--sigma-px", type=float, default=EdgeSettings().sigma_px)
    parser.add_argument("--three", action="store_true", help="three frames before and after")
    parser.add_argument("--method", choices=["thesis", "photometric"], default="photometric")
    parser.add_argument("--json", type=Path, default=Path("out/accuracy.json"))
    chosen = parser.parse_args()
    edges = EdgeSettings(chosen.sigma_px) if chosen.method == "thesis" else None
    options = AnalysisOptions(edges, three_and_three=chosen.three, method=chosen.method)
    with tempfile.TemporaryDirectory() as scratch:
        folders = chosen.folders or [render(Path(scratch) / "rendered", chosen.shots, chosen.seed)]
        figures = [compare(folder, options) for folder in folders]
    chosen.json.parent.mkdir(parents=True, exist_ok=True)
    chosen.json.write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    main()
