"""What the analysis workers call in these tests."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path


def measured(folder: Path, method: str) -> dict[str, object]:
    return {"status": "measured", "shot": folder.name, "method": method}


def refused(folder: Path, method: str) -> dict[str, object]:
    return {"status": "refused", "step": "markers", "reason": "only 2 markers"}


def broken(folder: Path, method: str) -> dict[str, object]:
    raise ValueError("a bug")


def not_finite(folder: Path, method: str) -> dict[str, object]:
    return {"status": "measured", "e": float("nan")}


def crashes_at_the_first(folder: Path, method: str) -> dict[str, object]:
    if folder.name.endswith("1"):
        os.kill(os.getpid(), signal.SIGSEGV)
    return {"status": "measured", "process": os.getpid()}


def never_ends(folder: Path, method: str) -> dict[str, object]:
    time.sleep(3600)
    return {}


def compiles_first(folder: Path, method: str) -> dict[str, object]:
    """Compile a function that is kept nowhere, and wait to be let go on."""
    from analysis import compiled

    for told in compiled._listeners:
        told(3, 60)
    while not (folder / "go-on").exists():
        time.sleep(0.01)
    return measured(folder, method)
