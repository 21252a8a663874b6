"""What the processes of jobs call in these tests."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable

from rigctl.errors import AnalysisInputError

Say = Callable[[str, float | None], None]


def answers(asked: dict[str, object], say: Say) -> dict[str, object]:
    say("half way", 0.5)
    return {"asked": asked, "process": os.getpid()}


def conditions(asked: dict[str, object], say: Say) -> dict[str, object]:
    return {"nice": os.nice(0), "threads": os.environ["OPENBLAS_NUM_THREADS"]}


def refuses(asked: dict[str, object], say: Say) -> dict[str, object]:
    raise AnalysisInputError("holds no poses", part="result-0001.json", todo="analyse it again")


def breaks(asked: dict[str, object], say: Say) -> dict[str, object]:
    raise ValueError("a bug")


def not_finite(asked: dict[str, object], say: Say) -> dict[str, object]:
    return {"e": float("nan")}


def crashes(asked: dict[str, object], say: Say) -> dict[str, object]:
    os.kill(os.getpid(), signal.SIGSEGV)
    return {}


def leaves(asked: dict[str, object], say: Say) -> dict[str, object]:
    sys.stdout.flush()
    os._exit(3)


def never_ends(asked: dict[str, object], say: Say) -> dict[str, object]:
    say(str(os.getpid()), None)
    threading.Event().wait()
    return {}
