"""Has stored shots analysed in processes of their own; the rig never waits for them.

Each worker is one thread with one process: a crash is then the crash of one known shot, its
signal can be named, and an analysis beyond its time can be ended. A shared pool offers neither. A
process that died is replaced.
"""

from __future__ import annotations

import json
import logging
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from queue import Empty, SimpleQueue

from rigctl.documents import Json
from rigctl.errors import RigError
from rigctl.jobs.attending import attend
from rigctl.jobs.failure import JobFailedError
from rigctl.jobs.worker_process import WorkerProcess, conditions
from rigctl.measuring.result_keeping import AGAIN, Keeper
from rigctl.store import Store

CLOSE_WAIT_S = 5.0


class AnalysisFailedError(RigError):
    """The analysis itself broke, as opposed to a shot that it refused."""

    code = "analysis-failed"


def cancelled() -> AnalysisFailedError:
    """Return the error of an analysis that somebody cancelled."""
    return AnalysisFailedError(
        "its analysis was cancelled; its frames are kept", todo="have it analysed again"
    )


@dataclass(frozen=True, slots=True)
class Compiling:
    """How far a process was that compiles its functions to machine code, when it said so last.

    Attributes
    ----------
    words
        In words.
    share
        The part of the time that it takes, from 0 to 1.
    taken_s
        Time since its shot was ordered, s.
    at_s
        When that was, by the monotonic clock, s.
    """

    words: str
    share: float
    taken_s: float = 0.0
    at_s: float = 0.0

    def left_s(self, now_s: float) -> float | None:
        """Return the time left at a time of the same clock, s; None while the pace says nothing.

        It falls evenly while one function is compiled, to half of what was left when that began:
        one that takes longer than was thought does not make an end of the others.
        """
        if self.share < TELLS_FROM:
            return None
        left = (1.0 - self.share) * self.taken_s / self.share
        return max(left - max(0.0, now_s - self.at_s), left / 2)


TELLS_FROM = 0.1
"""Share of compiling before which the pace says nothing of the rest."""


class AnalysisProcess:
    """One process, started when it is first needed and again after it was lost.

    Parameters
    ----------
    function
        `module:name` of a callable (arguments, progress) -> JSON object, imported in the process.
        Arguments are the `folder` and the `method`; progress, how far its compilation is.
    loads
        Modules that the process imports at its start: what a shot needs is slow to load.

    Attributes
    ----------
    compiling
        How far it is, while the shot under way waits for machine code; None: it waits for none.
    """

    def __init__(self, function: str, loads: Sequence[str] = ()) -> None:
        self._function, self._loads = function, tuple(loads)
        self._lock = threading.Lock()
        self._process: WorkerProcess | None = None
        self._analyses = self._is_unwanted = False
        self.ended = False
        self.compiling: Compiling | None = None
        self._ordered_s = 0.0

    def prepare(self) -> None:
        """Start the process before there is a shot; where it cannot be, its first shot says so."""
        with self._lock, suppress(JobFailedError, AnalysisFailedError):
            self._running()

    def analyse(self, folder: Path, method: str, timeout_s: float) -> Json:
        """Have one folder analysed; raise `AnalysisFailedError` if no result comes of it.

        Each function that is compiled meanwhile gives the analysis its time anew.
        """
        try:
            with self._lock:
                if self._is_unwanted:
                    raise cancelled()
                process = self._running()
                self._analyses = True
            self._ordered_s = time.monotonic()
            process.order(self._function, {"folder": str(folder), "method": method})
            result: Json = json.loads(attend(process, self._compiles, timeout_s, renewed=True))
        except JobFailedError as error:
            if self._is_unwanted:
                raise cancelled() from error
            raise AnalysisFailedError(
                f"the analysis failed: {error.what}", limit=error.limit, todo=error.todo
            ) from error
        finally:
            self.compiling = None
            with self._lock:
                # Killed after its result came, it may still look alive to the next shot.
                killed = self._analyses and self._is_unwanted
                self._analyses = False
                if self.ended or killed:
                    self._discard()
        return result

    def expect(self) -> None:
        """Forget an earlier `cancel`: the analysis that comes next is wanted."""
        self._is_unwanted = False

    def cancel(self) -> None:
        """Have the analysis under way, or since `expect` the next one, raise at once.

        The process of one that is under way is killed.
        """
        with self._lock:
            self._is_unwanted = True
            if self._analyses and self._process is not None:
                self._process.kill()

    def _compiles(self, words: str, share: float | None) -> None:
        now = time.monotonic()
        self.compiling = Compiling(words, share or 0.0, now - self._ordered_s, now)

    def end(self) -> None:
        """Kill the process; a waiting caller gets the error at once."""
        with self._lock:
            self.ended = True
            if self._analyses and self._process is not None:
                # Who waits for it gives back its pipe.
                self._process.kill()
            else:
                self._discard()

    def _running(self) -> WorkerProcess:
        if self.ended:
            raise AnalysisFailedError("the daemon ends")
        if self._process is None or not self._process.alive:
            self._discard()
            self._process = WorkerProcess(conditions(network=False, loads=self._loads), niceness=0)
        return self._process

    def _discard(self) -> None:
        if self._process is not None:
            self._process.close()
            self._process = None


_log = logging.getLogger(__name__)

ANALYSE = "rigctl.measuring.stored_shot:analysis_job"
LOADS = {"photometric": ("analysis.photometric.method",)}
"""What a shot measured by a method needs besides, and what is slow to load."""


@dataclass(slots=True, eq=False)
class _Order:
    """A shot that waits for its analysis or, by `worker`, is under way."""

    shot: str
    method: str
    queued_s: float
    worker: AnalysisProcess | None = None
    is_unwanted: bool = False


@dataclass(frozen=True, slots=True)
class Awaited:
    """How long a shot has waited for its analysis, s, and whether that is being cancelled."""

    gone_s: float
    is_cancelled: bool


class Analyser:
    """Analyses shots one after another in each of its workers.

    A result is written beside the frames before the shot's row becomes `analysed`, or `refused`
    where the frames cannot be measured. A worker that cannot be started, crashes or takes too long
    is replaced, and the shot is `refused` with that reason, or keeps the result that it has; the
    next shot gets a fresh attempt. A failed write is tried again for a while, as
    `Keeper` describes.

    Parameters
    ----------
    store
        Where the shots are.
    workers, method, timeout_s
        How many at a time, by which method, and the longest one may take, s.
    function
        As of `AnalysisProcess`.
    rest
        Waits so many seconds for the event of the analyser's end; returns whether it came.
    """

    def __init__(
        self,
        store: Store,
        *,
        workers: int,
        method: str,
        timeout_s: float,
        function: str = ANALYSE,
        rest: Callable[[threading.Event, float], bool] = threading.Event.wait,
    ) -> None:
        self._store, self._method, self._timeout_s = store, method, timeout_s
        self._ended = threading.Event()
        self._rest = rest
        self._waiting: SimpleQueue[_Order | None] = SimpleQueue()
        self._orders: set[_Order] = set()
        self._lock = threading.Lock()
        loads = [function.partition(":")[0], *LOADS.get(method, ())]
        self._workers = [AnalysisProcess(function, loads) for _ in range(workers)]
        self._threads = [
            threading.Thread(target=self._serve, args=(worker,), name="analysis", daemon=True)
            for worker in self._workers
        ]
        for thread in self._threads:
            thread.start()

    def prepare(self) -> None:
        """Have a worker load what it needs before there is a shot; returns at once."""
        threading.Thread(target=self._workers[0].prepare, name="prepare", daemon=True).start()

    def submit(self, shot: str) -> None:
        """Queue a stored shot, or one to be analysed again; returns at once."""
        self.submit_by(shot, self._method)

    def submit_by(self, shot: str, method: str) -> None:
        """Queue a shot to be analysed by another method; returns at once."""
        with self._lock:
            self._queue(_Order(shot, method, time.monotonic()))

    def _queue(self, order: _Order) -> None:
        self._orders.add(order)
        self._waiting.put(order)

    def cancel(self, shot: str) -> None:
        """End a shot's analysis, or have it skipped while it waits; returns at once.

        Its frames and earlier results stay, and so does machine code that was compiled for it. A
        shot that is under way and queued again is ended and skipped; one that neither waits nor is
        analysed stays as it is.
        """
        with self._lock:
            for order in self._orders:
                if order.shot == shot:
                    order.is_unwanted = True
                    if order.worker is not None:
                        order.worker.cancel()

    def awaited(self, shot: str) -> Awaited | None:
        """Return how the analysis of a shot stands; None: it neither waits nor is under way."""
        with self._lock:
            orders = [order for order in self._orders if order.shot == shot]
            if not orders:
                return None
            since = min(order.queued_s for order in orders)
            return Awaited(time.monotonic() - since, all(order.is_unwanted for order in orders))

    @property
    def compiling(self) -> Compiling | None:
        """How far a worker is that compiles machine code for its shot; None: none does."""
        far = (worker.compiling for worker in self._workers)
        return next((each for each in far if each is not None), None)

    def close(self) -> None:
        """End the workers; a shot under way is taken up again at the next start."""
        self._ended.set()
        for worker in self._workers:
            worker.end()
            self._waiting.put(None)
        for thread in self._threads:
            thread.join(CLOSE_WAIT_S)

    def _serve(self, worker: AnalysisProcess) -> None:
        keeper = Keeper(self._store, lambda wait_s: self._rest(self._ended, wait_s))
        while not worker.ended:
            try:
                order = self._waiting.get(timeout=keeper.idle_s)
            except Empty:
                keeper.try_again()
                continue
            if order is None:
                return
            try:
                self._analyse(worker, keeper, order)
            except Exception:  # noqa: BLE001 - the shots behind this one must still be analysed
                _log.exception("shot %s: its analysis could not be stored", order.shot)
            finally:
                with self._lock:
                    self._orders.discard(order)

    def _analyse(self, worker: AnalysisProcess, keeper: Keeper, order: _Order) -> None:
        shot, method = order.shot, order.method
        if self._store.shot(shot).is_without_frames:
            return
        if (before := keeper.begin(shot)) is None:
            # Its state is unchanged; without this it would wait for the next start.
            with self._lock:
                self._queue(replace(order))
            return
        try:
            with self._lock:
                if order.is_unwanted:
                    raise cancelled()
                worker.expect()
                order.worker = worker
            result = worker.analyse(self._store.folders.folder(shot), method, self._timeout_s)
        except Exception as error:  # noqa: BLE001 - whatever breaks is this shot's failure alone
            if not worker.ended:
                known = isinstance(error, AnalysisFailedError)
                if known and order.is_unwanted:
                    _log.info("shot %s: %s", shot, error)
                else:
                    _log.warning("shot %s: %s", shot, error, exc_info=error)
                why = str(error) if known else repr(error)
                keeper.fail(before, why, AnalysisFailedError.code)
            return
        finally:
            with self._lock:
                order.worker = None
        again = result.pop(AGAIN, [])
        keeper.keep(before, result)
        for other in again:
            self.submit_by(str(other), method)
