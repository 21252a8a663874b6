"""All that firing and stopping rest on, by one command: python -m benchmarks.safety.

Runs, one after another: stops under load and the dead man, kills at random moments, every fault in
every state, broken files, and shots in a row. Each prints its own table; a last table has them all.
`--share 0.1` takes a tenth of each, `--quick` a fiftieth. Ends 1 where one of them does not hold.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Part:
    """One command: its module, and its numbers in a whole run by their options."""

    what: str
    module: str
    whole: dict[str, float]

    def words(self, share: float) -> list[str]:
        """Return the options for a share of the whole: a count is whole, and at least one."""
        words = []
        for option, number in self.whole.items():
            part = share * number
            words += [option, f"{max(1, round(part)) if isinstance(number, int) else part:g}"]
        return words


QUICK = 0.02
PARTS = (
    Part("stops under load, dead man", "stop", {"--times": 100, "--kills": 5}),
    Part("kills at random moments", "kill", {"--kills": 1000}),
    Part("every fault in every state", "faults", {"--share": 1.0}),
    Part("broken files", "hostile_files", {"--files": 12_000}),
    Part("shots in a row", "soak", {"--shots": 10_000}),
)


def run(part: Part, share: float) -> tuple[bool, float, list[str]]:
    """Run one part, showing its lines as they come; return whether it held, its time, its lines."""
    words = part.words(share)
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
    asked.add_argument("--share", type=float, default=1.0, help="of each part's numbers")
    asked.add_argument("--quick", action="store_true", help="a fiftieth of each")
    options = asked.parse_args()
    table = []
    for part in PARTS:
        held, took_s, lines = run(part, QUICK if options.quick else options.share)
        table.append((part.what, held, took_s, lines[-1] if lines else ""))
    print(f"\n{'part':28} {'holds':>5} {'s':>6}  last line")
    for what, held, took_s, last in table:
        print(f"{what:28} {'yes' if held else 'NO':>5} {took_s:6.0f}  {last}")
    return 0 if all(held for _, held, _, _ in table) else 1


if __name__ == "__main__":
    sys.exit(main())
