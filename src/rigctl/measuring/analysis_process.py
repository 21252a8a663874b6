"""The process in which shots are analysed, one after another; replaced when it dies."""

from __future__ import annotations

import importlib
import json
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path

from rigctl.documents import Json
from rigctl.errors import RigError

CLOSE_WAIT_S = 5.0
AGAIN = "again"
"""Key of a result under which it names other shots to be analysed once more; it is not stored."""
NICENESS = 5
"""Of the analysis: a fire request goes before it, and everything of lower priority after it."""


class AnalysisFailedError(RigError):
    """The analysis itself broke, as opposed to a shot that it refused."""

    code = "analysis-failed"


@dataclass(frozen=True, slots=True)
class Compiling:
    """How far a process is that compiles its functions to machine code: `done` of about `of`."""

    done: int
    of: int


class AnalysisProcess:
    """One process, started when it is first needed and again after it was lost.

    Parameters
    ----------
    function
        `module:name` of a callable (folder, method) -> JSON object, imported in the process.
    loads
        Further modules that the process imports at its start: what a shot needs is slow to load.

    Attributes
    ----------
    compiling
        How far it is, while the shot under way waits for machine code; None: it waits for none.
    """

    def __init__(self, function: str, loads: Sequence[str] = ()) -> None:
        self._function, self._loads = function, tuple(loads)
        self._lock = threading.Lock()
        self._started: tuple[BaseProcess, Connection] | None = None
        self.ended = False
        self.compiling: Compiling | None = None

    def prepare(self) -> None:
        """Start the process before there is a shot; where it cannot be, its first shot says so."""
        with suppress(AnalysisFailedError):
            self._running()

    def analyse(self, folder: Path, method: str, timeout_s: float) -> Json:
        """Have one folder analysed; raise `AnalysisFailedError` if no result comes of it.

        Each function that is compiled meanwhile gives the analysis its time anew.
        """
        process, connection = self._running()
        try:
            connection.send((str(folder), method))
            result, failure = self._answer(process, connection, timeout_s)
        except (EOFError, OSError) as error:
            process.join(CLOSE_WAIT_S)
            raise AnalysisFailedError(
                f"the analysis process {_end_of(process)}", todo="analyse it again"
            ) from error
        if failure is not None:
            raise AnalysisFailedError(failure, todo="report the shot's folder")
        document: Json = json.loads(str(result))
        return document

    def _answer(
        self, process: BaseProcess, connection: Connection, timeout_s: float
    ) -> tuple[str | None, str | None]:
        try:
            while connection.poll(timeout_s):
                message: Compiling | tuple[str | None, str | None] = connection.recv()
                if not isinstance(message, Compiling):
                    return message
                self.compiling = message
        finally:
            self.compiling = None
        process.kill()
        raise AnalysisFailedError(
            "the analysis took too long", limit=f"{timeout_s:g} s", todo="analyse it again"
        )

    def end(self) -> None:
        """Kill the process; a waiting caller gets the error at once."""
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
                self._started = _start(self._function, self._loads)
            return self._started

    def _discard(self) -> None:
        if self._started is not None:
            self._started[1].close()
            self._started = None


def _start(function: str, loads: tuple[str, ...]) -> tuple[BaseProcess, Connection]:
    """Start a worker and return it with this end of its pipe; on failure nothing stays open."""
    context = multiprocessing.get_context("spawn")
    try:
        ours, theirs = context.Pipe()
        # Only the worker may hold its end, or its death would not be seen.
        with theirs:
            try:
                process = context.Process(
                    target=_work, args=(theirs, function, loads), name="analysis", daemon=True
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


def _work(connection: Connection, function: str, loads: tuple[str, ...]) -> None:
    """Serve in the worker's process until the daemon's end of the pipe closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # Loaded here: the daemon starts without the compiler.
    from analysis.compiled import on_compilation  # noqa: PLC0415

    on_compilation(lambda done, of: connection.send(Compiling(done, of)))
    module, _, name = function.partition(":")
    analyse: Callable[[Path, str], Json] = getattr(importlib.import_module(module), name)
    for each in loads:
        importlib.import_module(each)
    first = True
    while True:
        try:
            folder, method = connection.recv()
        except EOFError:
            return
        answer: tuple[str | None, str | None]
        try:
            answer = (json.dumps(analyse(Path(folder), method), allow_nan=False), None)
        except Exception as error:  # noqa: BLE001 - sent to the caller
            answer = (None, f"{type(error).__name__}: {error}")
        connection.send(answer)
        if first:
            # Not before: others may wait for the machine code that the first shot compiles.
            os.nice(NICENESS)
            first = False


def _end_of(process: BaseProcess) -> str:
    code = process.exitcode
    if code is not None and code < 0:
        return f"was killed by {signal.Signals(-code).name}"
    return f"ended with status {code}"
