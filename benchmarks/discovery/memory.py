"""How much memory and time a campaign of any length takes: rigctl model rank and explain --stream.

The whole command is measured, from poses.csv to the table, in a process of its own.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.discovery.goals import Goal, report
from benchmarks.discovery.options import Options
from simulators.challenge.campaign import run_campaign
from simulators.challenge.effects import switched
from simulators.challenge.folder import write_folder

HIDDEN = {"image-scale": 0.001}
SIZES, LARGE = (100, 1000, 10_000), 100_000
AT_ONCE = 100
MIB = 1024.0
"""ru_maxrss is in KiB."""
FIRST_SHOT = datetime(2026, 1, 1, 9, tzinfo=UTC)
ASKED_MEMORY, ASKED_TIME = 1.1, 11.0
COMMANDS = ("rank", "explain")
COMMAND = "from rigctl.cli import main; main()"


@dataclass(frozen=True, slots=True)
class Used:
    """What a command took: largest resident memory, MiB, and processor time, s."""

    shots: int
    memory_mib: float
    seconds: float


def run(options: Options) -> None:
    sizes = (*SIZES, *([LARGE] if options.large else []))
    report("memory", [goal for command in COMMANDS for goal in _goals(command, sizes)], [])


def _goals(command: str, sizes: Sequence[int]) -> list[Goal]:
    """Measure one command at all sizes."""
    used = [measured(command, shots) for shots in sizes]
    for one in used:
        print(
            f"  {command}, {one.shots} shots: {one.memory_mib:.0f} MiB, {one.seconds:.1f} s",
            flush=True,
        )
    goals = [
        Goal(
            f"{command}: memory of {more.shots} shots over that of {used[0].shots}",
            ASKED_MEMORY,
            more.memory_mib / used[0].memory_mib,
            0.0,
            1,
            at_least=False,
        )
        for more in used[1:]
    ]
    # With fewer shots the time that the program takes to start would flatter the ratio.
    goals += [
        Goal(
            f"{command}: time of {more.shots} shots over that of {less.shots}",
            ASKED_TIME,
            more.seconds / less.seconds,
            0.0,
            1,
            at_least=False,
        )
        for less, more in pairwise(used[1:])
    ]
    return goals


def measured(command: str, shots: int) -> Used:
    """Return what a command takes on a campaign of so many shots."""
    with TemporaryDirectory() as made:
        folder = Path(made) / "campaign"
        write_in_parts(folder, shots)
        arguments = ["model", command, str(folder), "--stream", "--json"]
        child = subprocess.Popen(
            [sys.executable, "-c", COMMAND, *arguments],
            stdout=subprocess.DEVNULL,
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        )
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        raise RuntimeError(f"rigctl {' '.join(arguments)} ended with {child.returncode}")
    return Used(shots, usage.ru_maxrss / MIB, usage.ru_utime + usage.ru_stime)


def write_in_parts(folder: Path, shots: int) -> None:
    """Write an exchange folder of poses, made so few shots at a time that memory does not grow."""
    with TemporaryDirectory() as made:
        part = Path(made) / folder.name
        for start in range(0, shots, AT_ONCE):
            fired = run_campaign(switched(HIDDEN), start, shots=min(AT_ONCE, shots - start))
            write_folder(part, fired)
            if start == 0:
                folder.mkdir(parents=True)
                (folder / "campaign.toml").write_bytes((part / "campaign.toml").read_bytes())
            for name in ("shots.csv", "poses.csv"):
                with (folder / name).open("a", encoding="utf-8") as file:
                    file.writelines(_renumbered(part / name, start))


def _renumbered(path: Path, start: int) -> Iterator[str]:
    """Return the lines of a table with its shots counted, and timed, from another start."""
    with path.open(encoding="utf-8") as file:
        names = next(file)
        if start == 0:
            yield names
        timed = names.startswith("shot,time,")
        for line in file:
            number, rest = line.split(",", 1)
            shot = int(number) + start
            if timed:
                when = FIRST_SHOT + timedelta(minutes=shot - 1)
                rest = f"{when:%Y-%m-%dT%H:%M:%SZ},{rest.split(',', 1)[1]}"
            yield f"{shot},{rest}"
