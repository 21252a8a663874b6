"""Run sections of the measurement: python -m benchmarks.discovery null --campaigns 400."""

from __future__ import annotations

import argparse

from benchmarks.discovery import (
    air,
    beside,
    blind,
    foreign,
    frames,
    hidden,
    lasting,
    memory,
    null,
    outside,
    pairs,
    power,
    pulls,
    removed,
    speed,
    unnamed,
)
from benchmarks.discovery.options import Options

SECTIONS = {
    "null": null.run,
    "power": power.run,
    "pulls": pulls.run,
    "pairs": pairs.run,
    "outside": outside.run,
    "unnamed": unnamed.run,
    "blind": blind.run,
    "removed": removed.run,
    "frames": frames.run,
    "hidden": hidden.run,
    "lasting": lasting.run,
    "foreign": foreign.run,
    "air": air.run,
    "beside": beside.run,
    "speed": speed.run,
    "speed-lasting": speed.run_lasting,
    "memory": memory.run,
}


def main() -> None:
    parser = argparse.ArgumentParser(prog="benchmarks.discovery", description=__doc__)
    parser.add_argument("section", choices=[*SECTIONS, "all"])
    parser.add_argument("--campaigns", type=int, default=100, help="in each cell")
    parser.add_argument("--shots", type=int, default=60, help="in each campaign")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--large", action="store_true", help="memory: 100 000 shots as well")
    parser.add_argument("--slow-px", type=float, help="pulls: poses as exact as filmed ones")
    help_ = "hidden, pulls: what all flights share of errors changes with the place"
    parser.add_argument("--by-place", action="store_true", help=help_)
    wanted = vars(parser.parse_args())
    section = wanted.pop("section")
    options = Options(**wanted)
    for name, run in SECTIONS.items():
        if section in {name, "all"}:
            run(options)


if __name__ == "__main__":
    main()
