"""How much faster two workers of a Dask cluster re-analyse: python -m benchmarks.cluster.

A campaign of rendered films is stored and analysed once more by `rigctl reanalyse`'s own code: by
one process alone, which analyses and stores in turn; by two processes of this host; and by a
cluster of two workers on it, both beside the one that stores. Each has done it before, so that
nothing is loaded or compiled in the time taken; learning the spheres, which a campaign asks for
once, is not counted. Between them two processes started by hand analyse the same shots, one alone
and both together: what this host gives to two at all. They take turns. A host's speed changes by
tens of percent from minute to minute, so a round compares each with the one process that went
before and after it within seconds, and the median of the rounds counts.

Prints times a shot by the clock, the processor time that all processes of each took, the ratio to
one process beside the 1.8 asked and beside what the host gives, the ratios of all rounds, and the
load of the host: two processors that are busy with other work cannot show it. The ratio by
processor times is what two processors would give that waited for nothing. Ends 1 below 1.8 by the
clock.
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
from statistics import median
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
    "DASK_DISTRIBUTED__SCHEDULER__WORK_STEALING_INTERVAL": "1s",
    "DASK_DISTRIBUTED__WORKER__MEMORY__MONITOR_INTERVAL": "1s",
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

    def mean(self, other: Taken) -> Taken:
        """Return the mean of two."""
        return Taken((self.wall_s + other.wall_s) / 2, (self.processor_s + other.processor_s) / 2)


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
    import_campaign(store, read_contents(home, silent), "benchmark", progress=silent)
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


@dataclass(frozen=True, slots=True)
class Round:
    """One turn of all ways within seconds of each other.

    Attributes
    ----------
    taken
        Of each way; of one process the mean of before and after the others.
    by_hand
        What two processes started by hand gain on one.
    """

    taken: dict[str, Taken]
    by_hand: float

    def gain(self, way: str) -> float:
        """Return how much faster a way is than one process, by the clock."""
        return self.taken[ALONE].wall_s / self.taken[way].wall_s

    def possible(self, way: str) -> float:
        """Return the same of two processors that would wait for nothing."""
        return 2 * self.taken[ALONE].processor_s / self.taken[way].processor_s


def measured(store: Store, shots: int, rounds: int, method: str) -> list[Round]:
    """Return all rounds but a first one, which only loads and compiles."""
    folders = [store.folders.folder(shot.id) for shot in store.catalogue.each("nylon")]
    found: list[Round] = []
    with ExitStack() as opened:
        plain = opened.enter_context(by_hand(folders, method))
        alone = Pool(Alone(), lambda: 1)
        here = opened.enter_context(pool(workers=2))
        two = opened.enter_context(pool(opened.enter_context(cluster())))
        for _ in range(rounds + 1):
            turn = [taken(store, shots, way, method) for way in (alone, two, here, alone)]
            times = {ALONE: turn[0].mean(turn[3]), TWO: turn[1], HERE: turn[2]}
            found.append(Round(times, 2 * plain.taken_s(1) / plain.taken_s(2)))
    return found[1:]


def main() -> int:
    """Measure all three; print what they took."""
    asked = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    asked.add_argument("--shots", type=int, default=96)
    asked.add_argument("--rounds", type=int, default=5)
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
        rounds = measured(store, options.shots, options.rounds, options.method)
    for way in (ALONE, HERE, TWO):
        wall = median(one.taken[way].wall_s for one in rounds)
        processor = median(one.taken[way].processor_s for one in rounds)
        print(
            f"{way:25} {1e3 * wall:6.1f} ms a shot, processors {1e3 * processor:.1f} ms: "
            f"{median(one.gain(way) for one in rounds):.2f} times one process"
        )
    by_hand_gain = median(one.by_hand for one in rounds)
    print(f"two processes by hand, storing nothing: {by_hand_gain:.2f} times one by hand")
    ratio = median(one.gain(TWO) for one in rounds)
    print(
        f"ratio {ratio:.2f} (asked {ASKED:g}), "
        f"{median(one.possible(TWO) for one in rounds):.2f} by processor times; of the rounds "
        f"{', '.join(f'{one.gain(TWO):.2f}' for one in rounds)}; {options.shots} shots, "
        f"{options.method}; load {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors"
    )
    return 0 if ratio >= ASKED else 1


if __name__ == "__main__":
    sys.exit(main())
