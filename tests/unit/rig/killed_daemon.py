"""Daemons that are killed at chosen points of one shot. Run by the recovery tests.

Usage: python killed_daemon.py FOLDER POINT... Each point has a process of its own, and a folder
below FOLDER with its number; the signals that ended them are printed, one a line.
"""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path

from rig_fakes import SETTINGS, Laboratory

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


def main(folder: Path, point: str) -> None:
    lab = Laboratory(folder / "data")

    def fired() -> None:
        if point == "before the byte":
            die()
        counted(folder)
        if point == "after the byte":
            die()

    def at_state(shot: ShotRecord) -> None:
        if point == f"row {shot.state}":
            die()

    lab.trigger.hooks["fire"] = fired
    for call in ("start", "mark", "collect", "stop"):
        if point == call:
            lab.capture.hooks[call] = die
    if point == "trigger armed":
        lab.trigger.hooks["arm"] = die
    lab.store.listeners.add(at_state)
    write = ShotFolders.write

    def write_and_die(*arguments: object) -> Path:
        written = write(*arguments)
        if point == "folder whole, row to come":
            die()
        return written

    ShotFolders.write = write_and_die
    token = lab.rig.arm(SETTINGS, "anna").token
    lab.rig.fire(token, "the key", "body", actor="anna")


def ended_by(folder: Path, point: str) -> int:
    """Run a daemon in a process of its own; return the signal that ended it, 0 for none."""
    folder.mkdir()
    if (child := os.fork()) == 0:
        main(folder, point)
        os._exit(0)
    _, status = os.waitpid(child, 0)
    return os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0


if __name__ == "__main__":
    # What is loaded is loaded once.
    for number, point in enumerate(sys.argv[2:]):
        sys.stdout.write(f"{ended_by(Path(sys.argv[1]) / str(number), point)}\n")
