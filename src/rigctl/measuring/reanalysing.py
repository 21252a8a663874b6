"""Has the shots of a campaign analysed once more, one after another, as one job."""

from __future__ import annotations

import json
import threading
from collections import Counter
from collections.abc import Callable, Sequence
from itertools import islice

from rigctl.errors import NotFoundError
from rigctl.jobs import JobFailedError, Task, Work
from rigctl.store import ShotRecord, ShotState, Store

ENDED = frozenset({ShotState.ANALYSED, ShotState.REFUSED})


def analysed_before(store: Store, campaign: str) -> list[str]:
    """Return the shots of a campaign whose analysis has ended, in the order of firing.

    Raises
    ------
    NotFoundError
        There is no such campaign, or no analysis of its shots has ended.
    """
    there = store.campaigns.one(campaign).shots
    found = [
        shot.id
        for shot in islice(store.catalogue.each(campaign), there)
        if shot.state in ENDED and not shot.is_without_frames
    ]
    if not found:
        raise NotFoundError(
            "no analysis of its shots has ended",
            part=f"campaign {campaign}",
            todo="await the analysis that is under way",
        )
    return found


def reanalysis(
    store: Store, analyse: Callable[[str], None], shots: Sequence[str], patience_s: float
) -> Work:
    """Return work that analyses shots again; results are added, none is replaced.

    One shot is handed over at a time, so that shots fired meanwhile wait for one at most.

    Parameters
    ----------
    analyse
        Queues a shot and returns at once.
    patience_s
        Longest time, s, in which no shot of the store changes while one is waited for.
    """

    def work(task: Task) -> str:
        watch = _Watch(task)
        stop_listening = store.listeners.add(watch.hear)
        try:
            for done, shot in enumerate(shots):
                watch.expect(shot)
                task.progress(f"analysing shot {shot}", done / len(shots))
                analyse(shot)
                watch.wait(shot, patience_s)
        finally:
            stop_listening()
        return json.dumps({"shots": len(shots), **{str(s): watch.ends[s] for s in sorted(ENDED)}})

    return work


class _Watch:
    """Hears how the analysis of one shot after another ends."""

    def __init__(self, task: Task) -> None:
        self.ends: Counter[ShotState] = Counter()
        self._task = task
        self._changed = threading.Condition()
        self._changes = 0
        self._expected: str | None = None
        task.on_cancel(self._wake)

    def hear(self, record: ShotRecord) -> None:
        with self._changed:
            self._changes += 1
            if record.id == self._expected and record.state in ENDED:
                # One that keeps an earlier result has the reason in `failure`.
                kept = record.failure is not None
                self.ends[ShotState.REFUSED if kept else record.state] += 1
                self._expected = None
            self._changed.notify_all()

    def expect(self, shot: str) -> None:
        with self._changed:
            self._expected = shot

    def wait(self, shot: str, patience_s: float) -> None:
        """Return when the expected shot's analysis has ended.

        Raises
        ------
        JobFailedError
            The work was cancelled, or no shot of the store changed for too long.
        """
        with self._changed:
            while self._expected is not None:
                if self._task.cancelled:
                    raise JobFailedError("cancelled")
                seen = self._changes
                self._changed.wait(patience_s)
                if self._changes == seen and not self._task.cancelled:
                    raise JobFailedError(
                        f"the analysis of shot {shot} does not end",
                        limit=f"{patience_s:g} s without any change",
                        todo="look at the daemon's log, then ask again",
                    )

    def _wake(self) -> None:
        with self._changed:
            self._changed.notify_all()
