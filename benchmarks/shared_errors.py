"""Which part of a sweep's errors all its shots share: python -m benchmarks.shared_errors DATA ...

Each DATA is the store of a simulated rig that fired one sweep. What is measured of each shot by
itself is held against the truth that the simulated world wrote down. The stated error of a shot is
its own and one that all shots have in common: of the scale, and of the drag of the air. The common
part is one draw in a whole sweep, so that only the errors of many sweeps show whether it is stated
as large as it is; it is fitted and taken out here. Prints, by sweep, the rms of all pulls, how far
the common part is off in its stated errors, and the rms of the pulls without it; then of all.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

NAMES = ("e", "v_n", "v_n_after", "v_s", "v_s_after")


def errors(data: Path, name: str) -> np.ndarray:
    """Return error, own and common stated error of each measured shot, shape (S, 3)."""
    return np.array(list(_errors(data, name))).reshape(-1, 3)


def _errors(data: Path, name: str) -> Iterator[tuple[float, float, float]]:
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
            yield own["value"] - true, own["sigma_own"], own["sigma_common"]


def parted(found: np.ndarray) -> tuple[float, float, float]:
    """Return rms of all pulls, the common part in its stated errors, rms of pulls without it."""
    off, own, common = found.T
    whole = off / np.hypot(own, common)
    share = float((off * common / own**2).sum() / (common**2 / own**2).sum())
    left = (off - share * common) / own
    return float(np.sqrt((whole**2).mean())), share, float(np.sqrt((left**2).mean()))


def main() -> None:
    """Print a line for each sweep and quantity, then all."""
    parser = argparse.ArgumentParser(prog="benchmarks.shared_errors", description=__doc__)
    parser.add_argument("stores", type=Path, nargs="+", metavar="DATA")
    stores = parser.parse_args().stores
    print(f"{'':12s}{'all pulls':>10s}{'common part':>13s}{'own pulls':>11s}")
    for name in NAMES:
        each = []
        for data in stores:
            found = errors(data, name)
            if len(found):
                each.append(parted(found))
                whole, share, left = each[-1]
                print(f"{name:12s}{whole:10.2f}{share:+13.2f}{left:11.2f}   {data}")
        whole, share, left = np.sqrt((np.array(each) ** 2).mean(axis=0))
        print(f"{name:12s}{whole:10.2f}{share:13.2f}{left:11.2f}   rms of {len(each)} sweeps")


if __name__ == "__main__":
    main()
