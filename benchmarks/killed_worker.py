"""A worker that analyses while the rig fires, and is killed: the part of the plan of faults.

The analysis itself is a stand-in. It answers at once, or holds until it is killed, as its method
says; process, supervision and store are the daemon's own.
"""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from rigctl.documents import Json
from rigctl.measuring.analysing import Analyser, AnalysisFailedError
from rigctl.progress import Progress
from rigctl.store import ShotRecord, Store
from rigctl.store.states import ShotState

if TYPE_CHECKING:
    from rigctl.daemon import Daemon

AT_ONCE, HELD = "at-once", "held"
ENDS_WITHIN_S = 60.0
NUMBER = "worker"
"""File in a held shot's folder that has the number of the worker's process."""

_holds: list[int] = []


def analyse(asked: Json, _progress: Progress) -> Json:
    """Answer at once; or write down which process this is, and hold until killed."""
    if asked["method"] == HELD:
        Path(asked["folder"], NUMBER).write_text(str(os.getpid()))
        while True:
            signal.pause()
    return {"status": "measured"}


class ByRequest(Analyser):
    """In the place of the analysis: a worker of the daemon's for those shots that are named."""

    def __init__(self, store: Store, **_: object) -> None:
        super().__init__(
            store,
            workers=1,
            method=AT_ONCE,
            timeout_s=ENDS_WITHIN_S,
            function=f"{__name__}:analyse",
        )

    def prepare(self) -> None:
        pass

    def submit(self, shot: str) -> None:
        pass


def hold(daemon: Daemon, shot: str) -> None:
    """Have a shot analysed by a worker that holds; return once it is under way."""
    number = daemon.store.folders.folder(shot) / NUMBER
    daemon.analyse_by(shot, HELD)
    _until(lambda: number.is_file() and number.read_text() != "")
    _holds.append(int(number.read_text()))
    number.unlink()


def kill() -> None:
    """Kill the worker that holds, if it lives still."""
    while _holds:
        with suppress(ProcessLookupError):
            os.kill(_holds.pop(), signal.SIGKILL)


def complaints(daemon: Daemon, held: str, following: str) -> Iterator[str]:
    """Yield what does not hold of the shot whose worker was killed, and of the one behind it."""
    shot = _ended(daemon, held)
    if (shot.state, shot.failure_code) != (ShotState.REFUSED, AnalysisFailedError.code):
        yield f"its shot is {shot.state}, {shot.failure_code}: {shot.failure}"
    elif "was killed by SIGKILL" not in (shot.failure or ""):
        yield f"its shot does not say so: {shot.failure}"
    daemon.analyse_by(following, AT_ONCE)
    shot = _ended(daemon, following, ShotState.ANALYSED)
    if shot.state is not ShotState.ANALYSED:
        yield f"the shot behind it is {shot.state}: {shot.failure}"


def _ended(daemon: Daemon, name: str, state: ShotState = ShotState.REFUSED) -> ShotRecord:
    _until(lambda: daemon.store.shot(name).state is state)
    return daemon.store.shot(name)


def _until(condition: Callable[[], bool]) -> None:
    """Wait until a condition holds, or the time is over; the caller looks which."""
    ends = time.monotonic() + ENDS_WITHIN_S
    while not condition() and time.monotonic() < ends:
        time.sleep(0.005)
