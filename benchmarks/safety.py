"""All that firing and stopping rest on, by one command: python -m benchmarks.safety.

Runs, one after another: stops under load and the dead man, kills at random moments, every fault in
every state, broken files, and shots in a row. Each prints its own table; a last table has them all.
`--quick` takes a fiftieth of each. Ends 1 where one of them does not hold.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Part:
    """One command: its module, and its words for a whole and for a quick run."""

    what: str
    module: str
    whole: tuple[str, ...]
    quick: tuple[str, ...]


PARTS = (
    Part(
        "stops under load, dead man",
        "stop",
        ("--times", "100", "--kills", "5"),
        ("--times", "2", "--kills", "1"),
    ),
    Part("kills at random moments", "kill", ("--kills", "1000"), ("--kills", "20")),
    Part("every fault in every state", "faults", (), ("--most", "10")),
    Part("broken files", "hostile_files", ("--files", "12000"), ("--files", "240")),
    Part("shots in a row", "soak", ("--shots", "10000"), ("--shots", "200")),
)


def run(part: Part, *, quick: bool) -> tuple[bool, float, list[str]]:
    """Run one part, showing its lines as they come; return whether it held, its time, its lines."""
    words = part.quick if quick else part.whole
    print(f"== {part.what}: python -m benchmarks.{part.module} {' '.join(words)}", flush=True)
    began = time.monotonic()
    command = [sys.executable, "-m", f"benchmarks.{part.module}", *words]
    lines = []
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            print(line, end="", flush=True)
            lines.append(line.rstrip())
    return process.returncode == 0, time.monotonic() - began, lines


def main() -> int:
    """Run every part, and print the table."""
    asked = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    asked.add_argument("--quick", action="store_true", help="a fiftieth of each")
    options = asked.parse_args()
    table = []
    for part in PARTS:
        held, took_s, lines = run(part, quick=options.quick)
        table.append((part.what, held, took_s, lines[-1] if lines else ""))
    print(f"\n{'part':28} {'holds':>5} {'s':>6}  last line")
    for what, held, took_s, last in table:
        print(f"{what:28} {'yes' if held else 'NO':>5} {took_s:6.0f}  {last}")
    return 0 if all(held for _, held, _, _ in table) else 1


if __name__ == "__main__":
    sys.exit(main())
