"""Tests on a machine that stops for seconds again and again: what they measure must be order.

    python -m benchmarks.stalls tests/unit/rig [--stall-s 2.5] [--run-s 0.4] [--seed 1]

Pytest and all processes below it are stopped together for `--stall-s`, after each stretch of about
`--run-s` of CPU time, or `LONGEST_S` of the clock. Time passes and nothing moves, as on a machine
busy with other work: every bound of the clock shorter than a stall runs out somewhere. A stall
costs no CPU time, so many may run side by side.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import time
from contextlib import suppress

from benchmarks.cpu_seconds import of_tree, tree

LONGEST_S = 3.0


def send(pids: list[int], number: signal.Signals) -> None:
    """Send a signal to each process that still is."""
    for pid in pids:
        with suppress(ProcessLookupError):
            os.kill(pid, number)


def stalled(command: list[str], stall_s: float, run_s: float, seed: int) -> int:
    """Run a command with stalls; return its exit code."""
    draw = random.Random(seed)
    with subprocess.Popen(command) as running:
        while running.poll() is None:
            until_s = of_tree(running.pid) + draw.expovariate(1.0 / run_s)
            latest_s = time.monotonic() + LONGEST_S
            while time.monotonic() < latest_s and of_tree(running.pid) < until_s:
                time.sleep(0.02)
            stopped = tree(running.pid)
            send(stopped, signal.SIGSTOP)
            time.sleep(stall_s)
            send(stopped, signal.SIGCONT)
    return running.returncode


def main() -> None:
    """Run the tests with stalls; exits as pytest does."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("tests", nargs="+")
    arguments.add_argument("--stall-s", type=float, default=2.5)
    arguments.add_argument("--run-s", type=float, default=0.4)
    arguments.add_argument("--seed", type=int, default=1)
    given = arguments.parse_args()
    # A test's own time-out is for a machine that runs.
    pytest = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-o", "timeout=3000"]
    sys.exit(stalled([*pytest, *given.tests], given.stall_s, given.run_s, given.seed))


if __name__ == "__main__":
    main()
