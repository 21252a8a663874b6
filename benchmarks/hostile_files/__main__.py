"""Files broken on purpose, given to every reader: python -m benchmarks.hostile_files.

Takes small valid files of every kind that rigctl reads, breaks each by chance (bits, cuts,
insertions, splices, length fields at extremes, and by its form), and gives it to the reader that a
command would give it to, in processes with 1 GB more of address space than they begin with and 5 s
of processor time a file. Prints what became of them and ends 1 where anything but reading or a
refusal in one sentence came of a file. Effects are left out: they are programs, and run by jobs.

    python -m benchmarks.hostile_files [--files 12000] [--first 0] [--seed 1] [--processes 2]
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.hostile_files.run import Findings, run


def table(findings: Findings) -> str:
    """Return the counts by kind, and of all."""
    heads = ("files", "read", "refused", "tracebacks", "hangs", "memory")
    lines = [f"{'kind':24}" + "".join(f"{head:>11}" for head in heads)]
    for kind in [*sorted(findings.kinds), None]:
        counts = [findings.count(outcome, kind) for outcome in (None, *Findings.OUTCOMES)]
        lines.append(f"{kind or 'all':24}" + "".join(f"{count:>11}" for count in counts))
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="benchmarks.hostile_files",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--files", type=int, default=12_000)
    parser.add_argument("--first", type=int, default=0, help="number of the first file")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--processes", type=int, default=2)
    asked = parser.parse_args()
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as room:
        numbers = range(asked.first, asked.first + asked.files)
        findings = run(numbers, asked.seed, asked.processes, Path(room))
    for fault in {fault.words[-200:]: fault for fault in findings.faults}.values():
        print(f"file {fault.number} ({fault.kind}): {fault.outcome}: {fault.words}\n")
    print(table(findings))
    print(f"slowest {findings.slowest_s:.2f} s of processor time; {time.monotonic() - began:.0f} s")
    sys.exit(1 if findings.faults else 0)


if __name__ == "__main__":
    main()
