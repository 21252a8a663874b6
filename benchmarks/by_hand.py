"""What two processes gain over one on this host, with nothing sent, stored or waited for.

Two processors share a cache, the way to the memory and their clock, and on a virtual machine may
be two threads of one core: two processes that do the same work side by side take longer than one
that does it alone. No pool and no cluster can gain more.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

WORK = """
import json, sys
from pathlib import Path
from rigctl.reanalysis.campaign import analysed, taught
folders, method = json.loads(sys.stdin.readline())
folders = [Path(folder) for folder in folders]
known = taught(folders[:3]) if method == "photometric" else None
for _ in sys.stdin:
    analysed(folders, method, known)
    print(flush=True)
"""
ENDS_WITHIN_S = 60.0


@dataclass(frozen=True, slots=True)
class ByHand:
    """Two processes, each of which analyses the same shots when it is told to."""

    processes: tuple[subprocess.Popen[str], ...]

    def taken_s(self, count: int) -> float:
        """Return what so many of them take that begin together, s."""
        began = time.monotonic()
        for process in self.processes[:count]:
            print(file=process.stdin, flush=True)
        for process in self.processes[:count]:
            if not process.stdout or not process.stdout.readline():
                raise RuntimeError("a process that was started by hand ended")
        return time.monotonic() - began


@contextmanager
def by_hand(folders: Sequence[Path], method: str) -> Iterator[ByHand]:
    """Start two processes that analyse the shots in these folders."""
    given = json.dumps([[str(folder) for folder in folders], method])
    started = tuple(
        subprocess.Popen(
            [sys.executable, "-c", WORK], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        for _ in range(2)
    )
    try:
        for process in started:
            print(given, file=process.stdin, flush=True)
        yield ByHand(started)
    finally:
        for process in started:
            process.communicate(timeout=ENDS_WITHIN_S)
