"""Work in a process of its own, of low priority: it can be killed, and firing never waits for it.

A process serves one job. Its start costs a second; a worker shared between jobs would hand the
memory and the faults of one to the next.
"""

from __future__ import annotations

import importlib
import json
import logging
import multiprocessing
import os
import signal
import threading
import time
import traceback
from collections.abc import Callable
from multiprocessing import connection as pipes
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any

from rigctl.errors import RigError
from rigctl.jobs.task import JobFailedError, Task, Work

_log = logging.getLogger(__name__)

LONGEST_S = 3600.0
END_WAIT_S = 5.0
NICENESS = 19

Json = dict[str, Any]
Say = Callable[[str, float | None], None]
Message = tuple[str, Any, Any]
"""("say", text, share), ("done", JSON text, None) or ("failed", sentence, code and trace)."""


def in_process(function: str, arguments: Json, longest_s: float = LONGEST_S) -> Work:
    """Return work that calls a function in a process of its own.

    Parameters
    ----------
    function
        `module:name` of a callable (arguments, say) -> JSON object, imported in the process.
    arguments
        JSON object that is handed over.
    longest_s
        The process is killed when it has not ended after this time, s.

    Returns
    -------
    Work that raises `JobFailedError` when the process cannot be started, dies, breaks or takes
    too long.
    """

    def work(task: Task) -> str:
        process, connection = _start(function, arguments)
        with connection:
            try:
                task.on_cancel(process.kill)
                return _attend(process, connection, task, longest_s)
            finally:
                process.kill()
                process.join(END_WAIT_S)

    return work


def _attend(process: BaseProcess, connection: Connection, task: Task, longest_s: float) -> str:
    ends_at = time.monotonic() + longest_s
    while connection.poll(max(0.0, ends_at - time.monotonic())):
        try:
            kind, content, more = connection.recv()
        except (EOFError, OSError) as error:
            process.join(END_WAIT_S)
            raise JobFailedError(
                f"the process {_end_of(process)}", todo="look at the host's memory, then ask again"
            ) from error
        if kind == "say":
            task.say(content, more)
        elif kind == "done":
            return str(content)
        else:
            raise _failed(content, *more)
    raise JobFailedError(
        "the work took too long", limit=f"{longest_s:g} s", todo="ask it of fewer shots"
    )


def _failed(sentence: str, code: str | None, trace: str) -> JobFailedError:
    if code is None:
        _log.error("a job broke:\n%s", trace)
        return JobFailedError(sentence, todo="look at the daemon's log and report it")
    return JobFailedError(sentence, because=code)


def _start(function: str, arguments: Json) -> tuple[BaseProcess, Connection]:
    """Start the process and return it with this end of its pipe."""
    context = multiprocessing.get_context("spawn")
    try:
        ours, theirs = context.Pipe(duplex=False)
        # Only the process may hold its end, or its death would not be seen.
        with theirs:
            try:
                process = context.Process(
                    target=_serve, args=(theirs, function, arguments), name="job", daemon=True
                )
                process.start()
            except BaseException:
                ours.close()
                raise
    except Exception as error:
        raise JobFailedError(
            f"the process could not be started: {error}",
            todo="free memory or processes on the host, then ask again",
        ) from error
    return process, ours


def _serve(connection: Connection, function: str, arguments: Json) -> None:
    """Do the work in its own process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.nice(NICENESS)
    # Read when the libraries are loaded, which happens below.
    os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    threading.Thread(target=_end_with_the_daemon, name="end with the daemon", daemon=True).start()

    def say(text: str, share: float | None) -> None:
        connection.send(("say", text, share))

    answer: Message
    try:
        module, _, name = function.partition(":")
        call: Callable[[Json, Say], Json] = getattr(importlib.import_module(module), name)
        answer = ("done", json.dumps(call(arguments, say), allow_nan=False), None)
    except RigError as error:
        answer = ("failed", error.sentence(), (error.code, ""))
    except Exception as error:  # noqa: BLE001 - whatever breaks is told, not lost
        trace = traceback.format_exc()
        answer = ("failed", f"{type(error).__name__}: {error}", (None, trace))
    connection.send(answer)


def _end_with_the_daemon() -> None:
    """End this process when its parent dies, however that dies."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        pipes.wait([parent.sentinel])
        os._exit(1)


def _end_of(process: BaseProcess) -> str:
    code = process.exitcode
    if code is not None and code < 0:
        return f"was killed by {signal.Signals(-code).name}"
    return f"ended with status {code}"
