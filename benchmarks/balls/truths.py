"""Films beside their truth, measured as a user does: python -m benchmarks.balls.truths FOLDER ...

Each folder is a campaign of one film (campaign.toml, shots.csv, frames) with a truth.json: bounces
(t, v_n, e, v_t) and frames (t, x, y, z, row, column, radius). Printed are errors and pulls, error
over stated error, of e, of speeds across, of instants and of places.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

Json = dict[str, Any]
Floats = np.ndarray[Any, np.dtype[np.float64]]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("folders", nargs="+", type=Path)
    asked = parser.parse_args()
    pulls: list[float] = []
    for folder in asked.folders:
        shot = measured(folder)
        told = json.loads((folder / "truth.json").read_text())
        print(f"== {folder.name}: {shot['status']} {shot.get('reason', '')}")
        if shot["status"] == "measured":
            pulls += bounces(shot, told)
            print(places(shot, told))
            print("\n".join(f"   note: {note}" for note in shot["notes"]))
    if pulls:
        print(f"== e of {len(pulls)} bounces: pull {math.sqrt(np.mean(np.square(pulls))):.2f} rms")


def measured(folder: Path) -> Json:
    """Return the document of a campaign's one shot."""
    command = [str(Path(sys.executable).with_name("rigctl")), "analyse", str(folder), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if not done.stdout:
        raise SystemExit(done.stderr)
    shot: Json = json.loads(done.stdout)["shots"][0]
    return shot


def bounces(shot: Json, told: Json) -> list[float]:
    """Print each bounce beside its truth; return the pulls of e."""
    pulls = []
    for found in shot["impacts"]:
        true = min(told["bounces"], key=lambda each: abs(each["frame"] - found["frame"]))
        e = found["e"]
        pulls.append((e["value"] - true["e"]) / e["sigma"])
        beside = [
            _pull(found[key], true[key][0] * math.copysign(1.0, found[key]["value"] * true[key][0]))
            for key in ("v_t", "v_t_after")
        ]
        rate = found["frame"] / found["contact_time_s"]
        late = (found["frame"] - true["frame"]) / (found["contact_time_sigma_s"] * rate)
        print(
            f"   e {e['value']:.4f} ± {e['sigma']:.4f}, off by {e['value'] - true['e']:+.4f}, "
            f"pull {pulls[-1]:+.2f}; v_n {_pull(found['v_n'], true['v_n']):+.1f}, v_t "
            f"{beside[0]:+.1f}, {beside[1]:+.1f}, instant {late:+.1f} of their errors"
        )
    return pulls


def _pull(quantity: Json, true: float) -> float:
    return float((quantity["value"] - true) / quantity["sigma"])


def places(shot: Json, told: Json) -> str:
    """Say how far places are off, and in their errors."""
    seen = shot["positions"]
    true = np.array(told["frames"])[seen["frame"]][:, 4:6]
    off = np.stack([seen["row_px"], seen["column_px"]], axis=1) - true
    sigmas = np.stack([seen["sigma_row_px"], seen["sigma_column_px"]], axis=1)
    scatter = np.stack([seen["scatter_row_px"], seen["scatter_column_px"]], axis=1)
    left = aligned_off(off, true, scatter)
    return (
        f"   {len(off)} places off by {_rms(off)} px, pull {_rms(off / sigmas)}; but for a shift "
        f"and a scale {np.median(np.abs(left), axis=0).round(3).tolist()} px in the middle, pull "
        f"{_rms(left / scatter)}"
    )


def aligned_off(off: Floats, true: Floats, scatter: Floats) -> Floats:
    """Return errors of places but for a shift and a scale, which flights do not tell, px, (N, 2).

    Parameters
    ----------
    off, true, scatter
        Errors, true places and stated errors (row, column), px, shape (N, 2): a place counts as
        much as it says.
    """
    design = np.column_stack([np.ones(len(true)), true[:, :2]])
    left = np.empty_like(off)
    for axis in range(2):
        weights = 1.0 / scatter[:, axis]
        solved = np.linalg.lstsq(design * weights[:, None], off[:, axis] * weights, rcond=None)
        left[:, axis] = off[:, axis] - design @ solved[0]
    return left


def _rms(values: Floats) -> list[float]:
    rounded: list[float] = np.sqrt((values**2).mean(axis=0)).round(3).tolist()
    return rounded


if __name__ == "__main__":
    main()
