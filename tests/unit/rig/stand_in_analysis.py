"""What the analysis workers call in these tests."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

from rigctl.documents import Json
from rigctl.progress import Progress


def measured(asked: Json, progress: Progress) -> dict[str, object]:
    return {"status": "measured", "shot": Path(asked["folder"]).name, "method": asked["method"]}


def refused(asked: Json, progress: Progress) -> dict[str, object]:
    return {"status": "refused", "step": "markers", "reason": "only 2 markers"}


def broken(asked: Json, progress: Progress) -> dict[str, object]:
    raise ValueError("a bug")


def not_finite(asked: Json, progress: Progress) -> dict[str, object]:
    return {"status": "measured", "e": float("nan")}


def crashes_at_the_first(asked: Json, progress: Progress) -> dict[str, object]:
    if asked["folder"].endswith("1"):
        os.kill(os.getpid(), signal.SIGSEGV)
    return {"status": "measured", "process": os.getpid()}


def never_ends(asked: Json, progress: Progress) -> dict[str, object]:
    time.sleep(3600)
    return {}


def compiles_first(asked: Json, progress: Progress) -> dict[str, object]:
    """Report as a compilation does, and wait to be let go on."""
    progress("3 of about 60 functions", 0.05)
    while not (Path(asked["folder"]) / "go-on").exists():
        time.sleep(0.01)
    return measured(asked, progress)
