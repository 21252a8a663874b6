"""Shots in a row, flat in memory, descriptors and threads: python -m benchmarks.soak.

One daemon over a simulated laboratory fires shot after shot, with short films and without the
analysis. The process is measured after every tenth of them, from `WARM_UP` shots on. What memory a
process comes to rest at is the same on a busy machine, and takes more shots there: as long as it
grows in the last four tenths of them by more than `MOST_MIB_PER_1000` and the allocator's spare,
shots go on, up to four times as many as asked for.
Prints the table; ends 1 where a shot was not stored, fires and shots differ, or the process grows
to the end, in memory, descriptors or threads.
"""

from __future__ import annotations

import argparse
import gc
import json
import os
import sys
import tempfile
import threading
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from benchmarks.faults import opened

OUT = Path("out/soak.json")
MOST_MIB_PER_1000 = 1.0
WARM_UP = 300
WINDOW = 200
"""Shots over which a process is looked at, and no fewer than four tenths of those asked for."""
SPARE_MIB = 4.0
"""Growth that the allocator alone may make."""
SPARE = 2
"""Descriptors and threads that come and go."""


@dataclass(frozen=True, slots=True)
class Size:
    """The process after some shots."""

    shots: int
    resident_mib: float
    descriptors: int
    threads: int

    def line(self) -> str:
        """Return a row of the table."""
        return f"{self.shots:8d} {self.resident_mib:10.1f} {self.descriptors:12d} {self.threads:8d}"


def size(shots: int) -> Size:
    """Measure this process."""
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    resident = pages * os.sysconf("SC_PAGE_SIZE") / 2**20
    return Size(shots, resident, len(os.listdir("/proc/self/fd")), threading.active_count())


def at_rest(sizes: Sequence[Size], window: int) -> bool:
    """Say whether a process no longer grows, by its sizes over the last so many shots."""
    last = sizes[-1]
    first = next(each for each in sizes if each.shots >= last.shots - window)
    allowed = SPARE_MIB + MOST_MIB_PER_1000 * (last.shots - first.shots) / 1000
    return (
        last.resident_mib - first.resident_mib <= allowed
        and last.descriptors <= first.descriptors + SPARE
        and last.threads <= first.threads + SPARE
    )


def main() -> int:
    """Fire, measure, print and write."""
    asked = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    asked.add_argument("--shots", type=int, default=10_000)
    asked.add_argument("--out", type=Path, default=OUT)
    options = asked.parse_args()
    step = max(1, options.shots // 10)
    window = max(WINDOW, 4 * step)
    sizes: list[Size] = []
    failed: list[str] = []
    print(f"{'shots':>8} {'memory MiB':>10} {'descriptors':>12} {'threads':>8}")
    with (
        tempfile.TemporaryDirectory() as temporary,
        opened(Path(temporary) / "data", answer_timeout_s=10.0) as bench,
    ):
        began = time.monotonic()
        for number in range(1, 4 * options.shots + 1):
            shot = bench.shoot()
            if shot.outcome != "stored":
                failed.append(f"{shot.id} {shot.outcome}: {shot.failure}")
            if number % step == 0 and number >= min(WARM_UP, options.shots - step):
                sizes.append(size(number))
                print(sizes[-1].line(), flush=True)
            if number % step == 0 and number >= options.shots and at_rest(sizes, window):
                break
        took = time.monotonic() - began
        fires = int(bench.laboratory.fires)
    rest = at_rest(sizes, window)
    sound = not failed and fires == number and rest
    print(f"{number} shots in {took:.0f} s, {fires} fires, not stored: {len(failed)}")
    print("at rest" if rest else "grows to the end")
    document = {
        "sizes": [asdict(each) for each in sizes],
        "failed": failed,
        "shots": number,
        "fires": fires,
    }
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(document, indent=1) + "\n")
    return 0 if sound else 1


if __name__ == "__main__":
    sys.exit(main())
