"""Shares the numbers of files among processes, and counts what became of them."""

from __future__ import annotations

import multiprocessing
import signal
import threading
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import ClassVar

from benchmarks.hostile_files.trying import serve

WAIT_S = 120.0
"""Longest wait for one file in all, for readers that wait without computing."""


@dataclass(frozen=True, slots=True)
class Fault:
    """A file of which neither a reading nor a refusal in one sentence came."""

    number: int
    kind: str
    outcome: str
    words: str


@dataclass(slots=True)
class Findings:
    """What became of all files, by kind and outcome."""

    OUTCOMES: ClassVar = ("read", "refused", "traceback", "hang", "memory")

    counts: Counter[tuple[str, str]] = field(default_factory=Counter)
    faults: list[Fault] = field(default_factory=list)
    slowest_s: float = 0.0

    @property
    def kinds(self) -> set[str]:
        """Kinds of files that were tried."""
        return {kind for kind, _ in self.counts}

    def count(self, outcome: str | None = None, kind: str | None = None) -> int:
        """Return how many files of a kind had an outcome; None: any."""
        return sum(
            count
            for (own, became), count in self.counts.items()
            if kind in {None, own} and outcome in {None, became}
        )


def run(numbers: Sequence[int], seed: int, processes: int, folder: Path) -> Findings:
    """Try the files of these numbers; the same numbers and seed break the same files."""
    findings, lock = Findings(), threading.Lock()
    left = iter(numbers)

    def share(k: int) -> None:
        life = 0
        while True:
            room = folder / f"{k}-{life}"
            room.mkdir()
            if _live(left, findings, lock, seed, room):
                return
            life += 1

    threads = [threading.Thread(target=share, args=(k,)) for k in range(processes)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return findings


def _live(
    left: Iterator[int], findings: Findings, lock: threading.Lock, seed: int, room: Path
) -> bool:
    """Try files in one process until none is left, or the process ends; say which."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=serve, args=(theirs, seed, room), daemon=True)
    process.start()
    theirs.close()
    kinds = ours.recv()
    before_s = 0.0
    while True:
        with lock:
            number = next(left, None)
        ours.send(number)
        if number is None:
            process.join()
            return True
        kind = kinds[number % len(kinds)]
        try:
            if not ours.poll(WAIT_S):
                raise EOFError
            outcome, words, after_s = ours.recv()
        except (EOFError, ConnectionError):
            outcome, words, after_s = *_end_of(process), before_s
        with lock:
            findings.counts[kind, outcome] += 1
            findings.slowest_s = max(findings.slowest_s, after_s - before_s)
            if outcome not in {"read", "refused"}:
                findings.faults.append(Fault(number, kind, outcome, words))
        if not process.is_alive():
            return False
        before_s = after_s


def _end_of(process: BaseProcess) -> tuple[str, str]:
    process.join(1.0)
    if process.exitcode is None or process.exitcode == -signal.SIGPROF:
        process.kill()
        process.join()
        return "hang", "it took longer than it may"
    return "traceback", f"the process ended with status {process.exitcode}"
