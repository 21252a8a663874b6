"""CPU time of processes with all that they start: it says what a busy host's clock cannot."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

TICKS = os.sysconf("SC_CLK_TCK")
OWN, WITH_ENDED = slice(11, 13), slice(11, 15)
"""Fields of /proc/PID/stat behind the name: user and system time, and those of ended children."""


def of_tree(root: int) -> float:
    """Return the CPU seconds of a process, of its children that ended, and of all that run."""
    return sum(_spent(pid, WITH_ENDED) for pid in tree(root))


def tree(root: int) -> list[int]:
    """Return a process and all that run below it."""
    return [root, *_below(root)]


def of_process(pid: int) -> float:
    """Return the CPU seconds of one process alone."""
    return _spent(pid, OWN)


def ran_and_waited(pid: int) -> tuple[float, float]:
    """Return how long the threads of a process ran, and waited for a processor, s.

    To the nanosecond, where `of_process` counts ticks of 10 ms. Threads that ended are left out.
    """
    ran, waited = 0, 0
    for thread in Path(f"/proc/{pid}/task").iterdir():
        with suppress(OSError):
            found = (thread / "schedstat").read_text().split()
            ran, waited = ran + int(found[0]), waited + int(found[1])
    return 1e-9 * ran, 1e-9 * waited


def children(pid: int) -> list[int]:
    """Return the running children of a process."""
    found: list[int] = []
    with suppress(OSError):
        for thread in Path(f"/proc/{pid}/task").iterdir():
            found += map(int, (thread / "children").read_text().split())
    return found


def _below(pid: int) -> list[int]:
    return [each for child in children(pid) for each in tree(child)]


def _spent(pid: int, fields: slice) -> float:
    try:
        behind_name = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return sum(map(int, behind_name[fields])) / TICKS
