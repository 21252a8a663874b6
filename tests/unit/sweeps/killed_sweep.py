"""Daemons that are killed at chosen points of the second step of a sweep. Run by the crash tests.

Usage: python killed_sweep.py FOLDER; each point gets a folder and a process of its own.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "rig"))

from bench import Bench
from points import POINTS

from rigctl.store import ShotRecord
from rigctl.store.folders import ShotFolders


def die() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def counted(folder: Path) -> None:
    """Count one fire where a kill cannot undo it."""
    descriptor = os.open(folder / "fires", os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    os.write(descriptor, b"fired\n")
    os.fsync(descriptor)
    os.close(descriptor)


def sweep_until(folder: Path, point: str) -> None:
    bench = Bench(folder / "data")
    fired: list[int] = []

    def at(name: str) -> bool:
        # The second step's own points come once the first has fired.
        return point == name and len(fired) >= (2 if name in AFTER_THE_BYTE else 1)

    def fire() -> None:
        if at("before the byte"):
            die()
        counted(folder)
        fired.append(1)
        if at("after the byte"):
            die()

    def at_state(shot: ShotRecord) -> None:
        if at(f"row {shot.state}"):
            die()

    def and_die(name: str, call: Callable[..., object]) -> Callable[..., object]:
        def wrapped(*arguments: object, **named: object) -> object:
            done = call(*arguments, **named)
            if at(name):
                die()
            return done

        return wrapped

    bench.lab.trigger.hooks["fire"] = fire
    bench.lab.capture.hooks["collect"] = lambda: die() if at("collect") else None
    bench.lab.store.listeners.add(at_state)
    bench.lab.store.sweeps.take = and_die("step taken", bench.lab.store.sweeps.take)
    bench.lab.store.sweeps.end = and_die("step ended", bench.lab.store.sweeps.end)
    ShotFolders.write = and_die("folder whole, row to come", ShotFolders.write)
    bench.run()


AFTER_THE_BYTE = {
    "after the byte",
    "row capturing",
    "collect",
    "folder whole, row to come",
    "row stored",
    "step ended",
}


def main(folder: Path) -> None:
    for number, point in enumerate(POINTS):
        own = folder / str(number)
        own.mkdir()
        child = os.fork()
        if child == 0:
            sweep_until(own, point)
            os._exit(0)
        _, status = os.waitpid(child, 0)
        if not os.WIFSIGNALED(status):
            sys.exit(f"the daemon lived through: {point}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
