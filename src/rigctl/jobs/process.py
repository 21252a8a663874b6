"""Work in a process of its own, of low priority: it can be killed, and firing never waits for it.

A process serves one job: a worker shared between jobs would hand the memory and the faults of one
to the next. Its start costs a second, which `Ready` spends before it is asked for.
"""

from __future__ import annotations

import json
import logging
import time

from rigctl.documents import Json
from rigctl.jobs.failure import JobFailedError
from rigctl.jobs.ready import started
from rigctl.jobs.task import Task, Work
from rigctl.jobs.worker_process import WorkerProcess

_log = logging.getLogger(__name__)

LONGEST_S = 3600.0
MOST_BYTES = 64 * 1024**2
"""Of one message of a job, its result with it."""


def in_process(function: str, arguments: Json, longest_s: float = LONGEST_S) -> Work:
    """Return work that calls a function in a process of its own.

    Parameters
    ----------
    function
        `module:name` of a callable (arguments, progress) -> JSON object, imported in the process.
    arguments
        JSON object that is handed over. Where it names a `database`, the process has the network.
    longest_s
        The process is killed when it has not ended after this time, s.

    Returns
    -------
    Work that raises `JobFailedError` when the process cannot be started, dies, breaks or takes
    too long.
    """

    def work(task: Task) -> str:
        process = started(task.ready, function, network=arguments.get("database") is not None)
        try:
            process.order(function, arguments)
            task.on_cancel(process.kill)
            return _attend(process, task, longest_s)
        finally:
            process.close()
            if task.ready is not None:
                task.ready.refill_soon()

    return work


def _attend(process: WorkerProcess, task: Task, longest_s: float) -> str:
    connection = process.connection
    ends_at = time.monotonic() + longest_s
    while connection.poll(max(0.0, ends_at - time.monotonic())):
        try:
            message = connection.recv_bytes(MOST_BYTES)
        except (EOFError, OSError) as error:
            raise JobFailedError(
                f"the process {process.end_in_words()}",
                todo="look at the host's memory, then ask again",
            ) from error
        match _message(message):
            case ["progress", str(text), float() | int() | None as share]:
                task.progress(text, share)
            case ["enclosed", str(words)]:
                task.enclosed(words)
            case ["done", str(result)]:
                return result
            case ["failed", str(sentence), str() | None as code, str(trace)]:
                raise _failed(sentence, code, trace)
            case _:
                raise JobFailedError(
                    "the process sent what is no message of a job",
                    todo="look at the files of your own effects",
                )
    raise JobFailedError(
        "the work took too long", limit=f"{longest_s:g} s", todo="ask it of fewer shots"
    )


def _message(content: bytes) -> object:
    """Return what a process says as JSON: nothing of it is ever unpacked into other objects."""
    try:
        return json.loads(content)
    except (ValueError, RecursionError):
        return None


def _failed(sentence: str, code: str | None, trace: str) -> JobFailedError:
    if code is None:
        _log.error("a job broke:\n%s", trace)
        return JobFailedError(sentence, todo="look at the daemon's log and report it")
    return JobFailedError(sentence, because=code)
