"""How much faster two workers of a Dask cluster re-analyse: python -m benchmarks.cluster.

A campaign of rendered films is stored and analysed once more by `rigctl reanalyse`'s own code: by
one process alone, which analyses and stores in turn; by two processes of this host; and by a
cluster of two workers on it, both beside the one that stores. Each has done it before, so that
nothing is loaded or compiled in the time taken; learning the spheres, which a campaign asks for
once, is not counted. Between them two processes started by hand analyse the same shots, one alone
and both together: what this host gives to two at all. They take turns, and the best round of each
counts.

Prints times a shot by the clock, the processor time that all processes of each took, the ratio to
one process beside the 1.8 asked and beside what the host gives, and the load of the host: two
processors that are busy with other work cannot show it. The ratio by processor times is what two
processors would give that waited for nothing. Ends 1 below 1.8 by the clock.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.by_hand import by_hand
from rigctl.exchange.contents import read_contents
from rigctl.exchange.importing import import_campaign
from rigctl.reanalysis import Pool, pool, reanalyse_campaign
from rigctl.store import Store
from simulators.world import write_campaign

ASKED = 1.8
RENDERED = 6
ENDS_WITHIN_S = 60.0
ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
CLUSTER = """
from distributed import LocalCluster
if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        print(cluster.scheduler_address, flush=True)
        input()
"""
QUIET = {
    "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False",
    "DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL": "1s",
    "DASK_DISTRIBUTED__ADMIN__SYSTEM_MONITOR__INTERVAL": "5s",
}
"""What a cluster looks at of itself for its dashboard; as docs/how-to/keep-a-campaign.md says."""
FRAMES = 24
ALONE, HERE, TWO = "one process", "two processes", "a cluster of two workers"


class Alone(Executor):
    """Analyses in the process that stores, when it is asked."""

    def submit(self, call: Callable[..., Any], /, *given: Any, **named: Any) -> Future[Any]:  # noqa: ANN401
        future = Future[Any]()
        future.set_result(call(*given, **named))
        return future


@dataclass(frozen=True, slots=True)
class Taken:
    """What a campaign took, s a shot: by the clock, and of the processors."""

    wall_s: float
    processor_s: float


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
        [sys.executable, "-c", CLUSTER],
        env={**os.environ, **QUIET},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        yield str(started.stdout.readline()).strip()  # type: ignore[union-attr]
    finally:
        started.communicate("\n", timeout=ENDS_WITHIN_S)


def silent(_text: str, _share: float | None) -> None:
    """Say nothing."""


def processor_s() -> float:
    """Return the processor time that this process and all below it have taken, s."""
    about = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        about[int(path.parent.name)] = int(fields[1]), int(fields[11]) + int(fields[12])
    ours, found = {os.getpid()}, 0
    while found < len(ours):
        found = len(ours)
        ours |= {process for process, (parent, _) in about.items() if parent in ours}
    return sum(about[process][1] for process in ours) / os.sysconf("SC_CLK_TCK")


def taken(store: Store, shots: int, workshop: Pool, method: str) -> Taken:
    """Return what analysing the campaign once more took."""
    outcomes = reanalyse_campaign(store, "nylon", method, workshop, silent)
    wall, processor = time.monotonic(), processor_s()
    failures = [outcome.failure for outcome in outcomes if outcome.failure is not None]
    wall, processor = time.monotonic() - wall, processor_s() - processor
    if failures:
        raise RuntimeError(failures[0])
    return Taken(wall / shots, processor / shots)


def measured(
    store: Store, shots: int, rounds: int, method: str
) -> tuple[dict[str, Taken], list[float]]:
    """Return the best rounds, after one that only loads and compiles.

    Returns
    -------
    Of each way; and of one process started by hand and of two, s.
    """
    folders = [store.folders.folder(shot.id) for shot in store.catalogue.each("nylon")]
    with ExitStack() as opened:
        plain = opened.enter_context(by_hand(folders, method))
        ways = {
            ALONE: Pool(Alone(), lambda: 1),
            HERE: opened.enter_context(pool(workers=2)),
            TWO: opened.enter_context(pool(opened.enter_context(cluster()))),
        }
        found: dict[str, list[Taken]] = {name: [] for name in ways}
        bounds: list[tuple[float, float]] = []
        for _ in range(rounds + 1):
            bounds.append((plain.taken_s(1), plain.taken_s(2)))
            for name, workshop in ways.items():
                found[name].append(taken(store, shots, workshop, method))
    best = {name: min(each[1:], key=lambda one: one.wall_s) for name, each in found.items()}
    return best, [min(each) for each in zip(*bounds[1:], strict=True)]


def main() -> int:
    """Measure all three; print what they took."""
    asked = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    asked.add_argument("--shots", type=int, default=96)
    asked.add_argument("--rounds", type=int, default=3)
    asked.add_argument("--method", choices=("photometric", "thesis"), default="photometric")
    options = asked.parse_args()
    if not ONE_THREAD.items() <= os.environ.items():
        # As in the processes of a pool. The libraries read it when they are loaded, which they are.
        again = [sys.executable, "-m", "benchmarks.cluster", *sys.argv[1:]]
        os.execve(sys.executable, again, {**os.environ, **ONE_THREAD})
    with (
        tempfile.TemporaryDirectory() as folder,
        closing(campaign(Path(folder), options.shots)) as store,
    ):
        best, (one_s, two_s) = measured(store, options.shots, options.rounds, options.method)
    for name, one in best.items():
        print(
            f"{name:25} {1e3 * one.wall_s:6.1f} ms a shot, processors {1e3 * one.processor_s:.1f} "
            f"ms: {best[ALONE].wall_s / one.wall_s:.2f} times one process"
        )
    print(f"two processes by hand, storing nothing: {2 * one_s / two_s:.2f} times one by hand")
    two = best[TWO]
    ratio = best[ALONE].wall_s / two.wall_s
    possible = 2 * best[ALONE].processor_s / two.processor_s
    print(
        f"ratio {ratio:.2f} (asked {ASKED:g}), {possible:.2f} by processor times; "
        f"{options.shots} shots, {options.method}; load {os.getloadavg()[0]:.1f} on "
        f"{os.cpu_count()} processors"
    )
    return 0 if ratio >= ASKED else 1


if __name__ == "__main__":
    sys.exit(main())
