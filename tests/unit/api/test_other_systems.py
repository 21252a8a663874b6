"""A notebook on Windows or macOS: a folder is measured and fitted without what Unix alone has."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ELSEWHERE = """
import importlib.abc, os, subprocess, sys, types

UNIX = {"fcntl", "grp", "pty", "pwd", "resource", "syslog", "termios", "tty"}
FUNCTIONS = "fork forkpty getgid getuid killpg nice sched_getaffinity setpriority setsid".split()


class Refuse(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name in UNIX:
            raise ImportError(f"{name} is not on this system")


for name in UNIX:
    sys.modules.pop(name, None)
sys.meta_path.insert(0, Refuse())
for name in FUNCTIONS:
    if hasattr(os, name):
        delattr(os, name)
locks = types.ModuleType("msvcrt")
locks.LK_NBLCK = 2
locks.locking = lambda file, mode, count: None
sys.modules["msvcrt"] = locks

import rigctl

campaign = rigctl.open(sys.argv[1], method="thesis")
shots = campaign.measure(workers=1)
print(len(shots), campaign.fit().rank().best is not None)
"""


def test_a_folder_of_frames_is_measured_and_fitted_without_unix(filmed: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", ELSEWHERE, str(filmed)],
        capture_output=True,
        text=True,
        timeout=500,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout == "3 True\n"
