"""What a sweep costs beyond its shots: python -m benchmarks.sweep_overhead.

The simulated rig fires a sweep with the analysis beside it. Noted is when each call into the rig
(arm, accept, wait) begins and ends; what lies between them, from the first arming to the last end,
is the sweep's own: choosing the step, taking it, settling it on disk, telling listeners. Prints
median, mean and longest of it, and its processor time, which a busy host does not lengthen; writes
out/sweep_overhead.json; ends 1 if the mean is above 50 ms a shot.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from rigctl.config import StoreSection, load
from rigctl.daemon import open_daemon
from rigctl.store import SweepState
from rigctl.sweeps.form import Sweep
from rigctl.sweeps.plan import plan_of
from rigctl.sweeps.runner import SweepRunner

if TYPE_CHECKING:
    from rigctl.rig.machine import Rig

OUT = Path("out/sweep_overhead.json")
ALLOWED_S = 0.05
LONGEST_S = 3600.0


Moment = tuple[float, float]
"""Monotonic time and processor time of the calling thread, s."""


def _now() -> Moment:
    return time.monotonic(), time.thread_time()


class _Watched:
    """A rig that notes when each call of a sweep begins and ends, in `Moment`s."""

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self.calls: list[tuple[str, Moment, Moment]] = []

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401
        found = getattr(self._rig, name)
        return self._noting(name, found) if name in {"arm", "accept", "wait"} else found

    def _noting(self, name: str, call: Callable[..., object]) -> Callable[..., object]:
        def noted(*arguments: object, **named: object) -> object:
            began = _now()
            try:
                return call(*arguments, **named)
            finally:
                self.calls.append((name, began, _now()))

        return noted


def overheads(calls: list[tuple[str, Moment, Moment]]) -> list[Moment]:
    """Return the times between the rig's calls, from each arming to the next."""
    own: list[Moment] = []
    for (_, _, ended), (name, began, _) in pairwise(calls):
        if name == "arm" or not own:
            own.append((0.0, 0.0))
        wall, cpu = own[-1]
        own[-1] = (wall + began[0] - ended[0], cpu + began[1] - ended[1])
    return own


def main() -> int:
    """Fire the sweep; print and write what it cost."""
    asked = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    asked.add_argument("--shots", type=int, default=24)
    asked.add_argument("--out", type=Path, default=OUT)
    options = asked.parse_args()
    shot = {"pressure_a_kpa": 40.0, "pressure_b_kpa": 40.0, "offset_mm": 6.0}
    form = Sweep.model_validate_json(
        json.dumps(
            {
                "shots": [shot | {"repeat": options.shots}],
                "until": {"coefficient": "e", "sigma": 1e-9},
            }
        )
    )
    with tempfile.TemporaryDirectory() as folder:
        store = StoreSection(folder=folder)
        configuration = load().model_copy(update={"store": store})
        with open_daemon(configuration) as daemon:
            watched = _Watched(daemon.rig)
            runner = SweepRunner(cast("Rig", watched), daemon.store, configuration)
            began = time.monotonic()
            sweep = runner.start(plan_of(form), "key", "", "the benchmark").record.id
            runner.wait(LONGEST_S)
            lasted = time.monotonic() - began
            record = runner.status(sweep).record
    if record.state is not SweepState.COMPLETED:
        print(f"the sweep is {record.state}: {record.reason}")
        return 1
    own, cpu = zip(*overheads(watched.calls), strict=True)
    found = {
        "shots": options.shots,
        "seconds_a_shot": lasted / options.shots,
        "median_s": statistics.median(own),
        "mean_s": statistics.fmean(own),
        "longest_s": max(own),
        "processor_s": statistics.fmean(cpu),
    }
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(found, indent=1) + "\n")
    print(
        f"{options.shots} shots, {found['seconds_a_shot']:.2f} s each; of these the sweep's own: "
        f"median {1e3 * found['median_s']:.1f} ms, mean {1e3 * found['mean_s']:.1f} ms, longest "
        f"{1e3 * found['longest_s']:.1f} ms, processor {1e3 * found['processor_s']:.1f} ms; "
        f"{1e3 * ALLOWED_S:g} ms are allowed"
    )
    return 0 if found["mean_s"] <= ALLOWED_S else 1


if __name__ == "__main__":
    sys.exit(main())
