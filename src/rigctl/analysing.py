"""Has stored shots analysed in processes of their own; the rig never waits for them.

Each worker is one thread with one process: a crash is then the crash of one known shot, its
signal can be named, and an analysis beyond its time can be ended. A shared pool offers neither.
"""

from __future__ import annotations

import importlib
import json
import logging
import multiprocessing
import signal
import threading
from collections.abc import Callable
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from rigctl.errors import RigError
from rigctl.store import Change, ShotState, Store

_log = logging.getLogger(__name__)

Json = dict[str, Any]
ANALYSE = "rigctl.stored_shot:analyse_stored_shot"
CLOSE_WAIT_S = 5.0


class AnalysisFailedError(RigError):
    """The analysis itself broke, as opposed to a shot that it refused."""

    code = "analysis-failed"


class Analyser:
    """Analyses shots one after another in each of its workers.

    A result is written beside the frames before the shot's row says `analysed`, or `refused`
    where the frames cannot be measured. A worker that cannot be started, crashes or takes too long
    is replaced, and the shot is `refused` with that reason; the next shot gets a fresh attempt.

    Parameters
    ----------
    store
        Where the shots are.
    workers, method, timeout_s
        How many at a time, by which method, and the longest one may take, s.
    function
        `module:name` of a callable (folder, method) -> JSON object, imported in the worker.
    """

    def __init__(
        self,
        store: Store,
        *,
        workers: int,
        method: str,
        timeout_s: float,
        function: str = ANALYSE,
    ) -> None:
        self._store, self._method, self._timeout_s = store, method, timeout_s
        self._waiting: SimpleQueue[tuple[str, str] | None] = SimpleQueue()
        self._workers = [_Worker(function) for _ in range(workers)]
        self._threads = [
            threading.Thread(target=self._serve, args=(worker,), name="analysis", daemon=True)
            for worker in self._workers
        ]
        for thread in self._threads:
            thread.start()

    def submit(self, shot: str) -> None:
        """Queue a stored shot, or one to be analysed again; returns at once."""
        self.submit_by(shot, self._method)

    def submit_by(self, shot: str, method: str) -> None:
        """Queue a shot to be analysed by another method; returns at once."""
        self._waiting.put((shot, method))

    def close(self) -> None:
        """End the workers; a shot under way is taken up again at the next start."""
        for worker in self._workers:
            worker.end()
            self._waiting.put(None)
        for thread in self._threads:
            thread.join(CLOSE_WAIT_S)

    def _serve(self, worker: _Worker) -> None:
        while not worker.ended and (asked := self._waiting.get()) is not None:
            shot, method = asked
            try:
                self._analyse(worker, shot, method)
            except Exception:  # noqa: BLE001 - the shots behind this one must still be analysed
                _log.exception("shot %s: its analysis could not be stored", shot)

    def _analyse(self, worker: _Worker, shot: str, method: str) -> None:
        if self._store.shot(shot).is_without_frames:
            return
        self._store.move(shot, ShotState.ANALYSING)
        folder = self._store.folders.folder(shot)
        try:
            result = worker.ask(folder, method, self._timeout_s)
        except Exception as error:  # noqa: BLE001 - whatever breaks is this shot's failure alone
            if not worker.ended:
                _log.warning("shot %s: %s", shot, error, exc_info=error)
                known = isinstance(error, AnalysisFailedError)
                why = Change(
                    failure=str(error) if known else repr(error),
                    failure_code=AnalysisFailedError.code,
                )
                self._store.move(shot, ShotState.REFUSED, why)
            return
        number = self._store.folders.add_result(shot, result)
        if result.get("status") == "refused":
            why = Change(results=number, failure=str(result.get("reason")), failure_code="refused")
            self._store.move(shot, ShotState.REFUSED, why)
        else:
            self._store.move(shot, ShotState.ANALYSED, Change(results=number))


class _Worker:
    """One process, started when it is first needed and again after it was lost."""

    def __init__(self, function: str) -> None:
        self._function = function
        self._lock = threading.Lock()
        self._started: tuple[BaseProcess, Connection] | None = None
        self.ended = False

    def ask(self, folder: Path, method: str, timeout_s: float) -> Json:
        """Have one folder analysed; raise `AnalysisFailedError` if no result comes of it."""
        process, connection = self._running()
        try:
            connection.send((str(folder), method))
            if not connection.poll(timeout_s):
                process.kill()
                raise AnalysisFailedError(
                    "the analysis took too long", limit=f"{timeout_s:g} s", todo="analyse it again"
                )
            result, failure = connection.recv()
        except (EOFError, OSError) as error:
            process.join(CLOSE_WAIT_S)
            raise AnalysisFailedError(
                f"the analysis process {_end_of(process)}", todo="analyse it again"
            ) from error
        if failure is not None:
            raise AnalysisFailedError(failure, todo="report the shot's folder")
        document: Json = json.loads(result)
        return document

    def end(self) -> None:
        """Kill the process; whoever waits for it is told at once."""
        with self._lock:
            self.ended = True
            if self._started is not None:
                process, _ = self._started
                process.kill()
                process.join(CLOSE_WAIT_S)

    def _running(self) -> tuple[BaseProcess, Connection]:
        with self._lock:
            if self.ended:
                raise AnalysisFailedError("the daemon ends")
            if self._started is None or not self._started[0].is_alive():
                self._discard()
                self._started = _start(self._function)
            return self._started

    def _discard(self) -> None:
        if self._started is not None:
            self._started[1].close()
            self._started = None


def _start(function: str) -> tuple[BaseProcess, Connection]:
    """Start a worker and return it with this end of its pipe; on failure nothing stays open."""
    context = multiprocessing.get_context("spawn")
    try:
        ours, theirs = context.Pipe()
        # Only the worker may hold its end, or its death would not be seen.
        with theirs:
            try:
                process = context.Process(
                    target=_work, args=(theirs, function), name="analysis", daemon=True
                )
                process.start()
            except BaseException:
                ours.close()
                raise
    except Exception as error:
        raise AnalysisFailedError(
            f"the analysis process could not be started: {error}",
            todo="free memory or processes on the host, then analyse it again",
        ) from error
    return process, ours


def _work(connection: Connection, function: str) -> None:
    """Serve in the worker's process until the daemon's end of the pipe closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    module, _, name = function.partition(":")
    analyse: Callable[[Path, str], Json] = getattr(importlib.import_module(module), name)
    while True:
        try:
            folder, method = connection.recv()
        except EOFError:
            return
        answer: tuple[str | None, str | None]
        try:
            answer = (json.dumps(analyse(Path(folder), method), allow_nan=False), None)
        except Exception as error:  # noqa: BLE001 - whatever breaks is told, not lost
            answer = (None, f"{type(error).__name__}: {error}")
        connection.send(answer)


def _end_of(process: BaseProcess) -> str:
    code = process.exitcode
    if code is not None and code < 0:
        return f"was killed by {signal.Signals(-code).name}"
    return f"ended with status {code}"
