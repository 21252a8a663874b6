"""Which part of a sweep's errors all its shots share: python -m benchmarks.shared_errors DATA ...

Each DATA is the store of a simulated rig that fired one sweep. What is measured of each shot by
itself is held against the truth that the simulated world wrote down. The stated error of a shot is
its own and one that all shots have in common: of the scale, and of the drag of the air. The common
part is one draw in a whole sweep, so that only the errors of many sweeps show whether it is stated
as large as it is; it is fitted and taken out here.

Prints, by sweep: by how much the values are off (rms; of velocities in percent), the rms of all
pulls and the largest, how far the common part is off in its stated errors, and the rms of the pulls
without it; then of all. Asked of a sweep: e within 0.001, v_n within 0.1 %, pulls between 0.8 and
1.25, none above 4.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

NAMES = ("e", "v_n", "v_n_after", "v_s", "v_s_after")


class Errors(NamedTuple):
    """Of one quantity of the shots of a sweep.

    Attributes
    ----------
    off
        Rms of what the values are off, of velocities in percent of the true ones.
    pulls, largest
        Rms of the errors over the stated ones, and the largest.
    common
        How far the part that all shots share is off, in its stated errors.
    own
        Rms of the pulls of each shot's own errors, without that part.
    """

    off: float
    pulls: float
    largest: float
    common: float
    own: float


def measured(data: Path, name: str) -> np.ndarray:
    """Return error, own and common stated error and true value of each shot, shape (S, 4)."""
    return np.array(list(_measured(data, name))).reshape(-1, 4)


def _measured(data: Path, name: str) -> Iterator[tuple[float, float, float, float]]:
    lines = (data / "laboratory/truth/truth.jsonl").read_text(encoding="utf-8").splitlines()
    truths = {truth["shot"]: truth for truth in map(json.loads, lines)}
    for folder in sorted((data / "shots").glob("*/*")):
        results = sorted(folder.glob("result-*.json"))
        truth = truths.get(int(folder.name.rpartition("-")[2]))
        if not results or truth is None or truth["missed"]:
            continue
        found: dict[str, Any] = json.loads(results[-1].read_text(encoding="utf-8"))
        own = found.get(name) or {}
        if own.get("value") is not None:
            true = -truth["v_n_after"] / truth["v_n"] if name == "e" else truth[name]
            yield own["value"] - true, own["sigma_own"], own["sigma_common"], true


def errors_of(found: np.ndarray, *, percent: bool) -> Errors:
    """Return how far the shots of one sweep are off."""
    off, own, common, true = found.T
    pulls = off / np.hypot(own, common)
    share = float((off * common / own**2).sum() / (common**2 / own**2).sum())
    left = (off - share * common) / own
    by = off / true * 100.0 if percent else off
    return Errors(_rms(by), _rms(pulls), float(np.abs(pulls).max()), share, _rms(left))


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def main() -> None:
    """Print a line for each sweep and quantity, then all."""
    parser = argparse.ArgumentParser(prog="benchmarks.shared_errors", description=__doc__)
    parser.add_argument("stores", type=Path, nargs="+", metavar="DATA")
    stores = parser.parse_args().stores
    titles = ("off (rms)", "all pulls", "largest", "common part", "own pulls")
    print(f"{'':14s}" + "".join(f"{title:>12s}" for title in titles))
    for name in NAMES:
        sweeps = [(data, found) for data in stores if len(found := measured(data, name))]
        if not sweeps:
            parser.error(f"no store holds a measured {name}: let a daemon end its measuring first")
        each = [errors_of(found, percent=name != "e") for _, found in sweeps]
        title = name if name == "e" else f"{name} %"
        for (data, found), errors in zip(sweeps, each, strict=True):
            print(f"{title:14s}{_row(errors)}   {data}, {len(found)} shots")
        middle = Errors(*np.sqrt((np.array(each) ** 2).mean(axis=0)).tolist())
        worst = middle._replace(largest=max(errors.largest for errors in each))
        print(f"{title:14s}{_row(worst)}   rms of {len(each)} sweeps, the largest of all")


def _row(errors: Errors) -> str:
    return (
        f"{errors.off:12.5f}{errors.pulls:12.2f}{errors.largest:12.2f}"
        f"{errors.common:+12.2f}{errors.own:12.2f}"
    )


if __name__ == "__main__":
    main()
