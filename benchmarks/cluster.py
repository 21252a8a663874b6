"""How much faster two workers of a Dask cluster re-analyse: python -m benchmarks.cluster.

A campaign of rendered films is stored and analysed once more by `rigctl reanalyse`'s own code: by
one process of this host, then by a cluster of two workers on it. Each has analysed it before, so
that nothing is loaded or compiled in the time taken; learning the spheres, which a campaign asks
for once, is not counted. Prints times a shot, the processor time of the process that stores, the
ratio beside the 1.8 asked, and the load of the host: two busy processors cannot show it. Ends 1
below it.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path

from rigctl.exchange.contents import read_contents
from rigctl.exchange.importing import import_campaign
from rigctl.reanalysis import Pool, pool, reanalyse_campaign
from rigctl.store import Store
from simulators.world import write_campaign

ASKED = 1.8
RENDERED = 6
ENDS_WITHIN_S = 60.0
CLUSTER = """
from distributed import LocalCluster
if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        print(cluster.scheduler_address, flush=True)
        input()
"""
FRAMES = 24


@dataclass(frozen=True, slots=True)
class Taken:
    """What a campaign took, s a shot: by the clock, and of the process that stores the results."""

    wall_s: float
    storing_s: float


def campaign(folder: Path, shots: int) -> Store:
    """Return a store with a campaign whose films are a few rendered ones, over and over."""
    home = folder / "nylon"
    offsets = [2.0 * k for k in range(RENDERED)]
    write_campaign(home, [40.0] * RENDERED, offsets, 3, frames=FRAMES)
    head, *rows = (home / "shots.csv").read_text().splitlines()
    for k in range(RENDERED, shots):
        original = home / "frames" / f"{k % RENDERED + 1:04d}.tiff"
        shutil.copy(original, original.with_name(f"{k + 1:04d}.tiff"))
        rows.append(f"{k + 1},{rows[k % RENDERED].partition(',')[2]}")
    (home / "shots.csv").write_text("\n".join([head, *rows]) + "\n")
    store = Store(folder / "data")
    import_campaign(store, read_contents(home, silent), "benchmark", say=silent)
    return store


@contextmanager
def cluster() -> Iterator[str]:
    """Run a scheduler and two workers in processes of their own; give the scheduler's address."""
    started = subprocess.Popen(
        [sys.executable, "-c", CLUSTER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    try:
        yield str(started.stdout.readline()).strip()  # type: ignore[union-attr]
    finally:
        started.communicate("\n", timeout=ENDS_WITHIN_S)


def silent(_text: str, _share: float | None) -> None:
    """Say nothing."""


def taken(store: Store, shots: int, workshop: Pool, method: str) -> Taken:
    """Return what analysing the campaign took, the second time."""
    for _ in range(2):
        outcomes = reanalyse_campaign(store, "nylon", method, workshop, silent)
        wall, processor = time.monotonic(), time.process_time()
        failures = [outcome.failure for outcome in outcomes if outcome.failure is not None]
        wall, processor = time.monotonic() - wall, time.process_time() - processor
        if failures:
            raise RuntimeError(failures[0])
    return Taken(wall / shots, processor / shots)


def main() -> int:
    """Measure both; print what they took."""
    asked = argparse.ArgumentParser(description=__doc__.splitlines()[0])  # type: ignore[union-attr]
    asked.add_argument("--shots", type=int, default=48)
    asked.add_argument("--method", choices=("photometric", "thesis"), default="photometric")
    options = asked.parse_args()
    with (
        tempfile.TemporaryDirectory() as folder,
        closing(campaign(Path(folder), options.shots)) as store,
    ):
        with pool(workers=1) as workshop:
            one = taken(store, options.shots, workshop, options.method)
        with cluster() as address, pool(address) as workshop:
            two = taken(store, options.shots, workshop, options.method)
    for name, found in (("one process", one), ("a cluster of two workers", two)):
        print(
            f"{name:26} {1e3 * found.wall_s:6.1f} ms a shot, storing {1e3 * found.storing_s:.1f} ms"
        )
    ratio = one.wall_s / two.wall_s
    print(
        f"ratio {ratio:.2f} (asked {ASKED:g}); {options.shots} shots, {options.method}; load "
        f"{os.getloadavg()[0]:.1f} on {os.cpu_count()} processors"
    )
    return 0 if ratio >= ASKED else 1


if __name__ == "__main__":
    sys.exit(main())
