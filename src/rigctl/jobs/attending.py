"""Awaits the answer to an order that a worker's process was given."""

from __future__ import annotations

import json
import logging
import time
from collections.abc import Callable

from rigctl.jobs.failure import JobFailedError
from rigctl.jobs.worker_process import WorkerProcess
from rigctl.progress import Progress

_log = logging.getLogger(__name__)

MOST_BYTES = 64 * 1024**2
"""Of one message of a process, its result with it."""


def attend(
    process: WorkerProcess,
    progress: Progress,
    limit_s: float,
    *,
    enclosed: Callable[[str], None] = lambda _: None,
    renewed: bool = False,
) -> str:
    """Return a JSON object as text: what the order that the process has gives.

    Parameters
    ----------
    progress, enclosed
        As of a `Task`.
    limit_s
        Longest time that it may take, s.
    renewed
        Whether each report of progress gives it that time anew.

    Raises
    ------
    JobFailedError
        The work failed; or the process died, answered something else or took too long, and is
        closed.
    """
    ends_at = time.monotonic() + limit_s
    while process.connection.poll(max(0.0, ends_at - time.monotonic())):
        try:
            message = process.connection.recv_bytes(MOST_BYTES)
        except (EOFError, OSError) as error:
            how = process.end_in_words()
            process.close()
            raise JobFailedError(
                f"the process {how}",
                todo="look at the host's memory, then ask again",
            ) from error
        match _message(message):
            case ["progress", str(text), float() | int() | None as share]:
                progress(text, share)
                if renewed:
                    ends_at = time.monotonic() + limit_s
            case ["enclosed", str(words)]:
                enclosed(words)
            case ["done", str(result)]:
                return result
            case ["failed", str(sentence), str() | None as code, str(trace)]:
                raise _failed(sentence, code, trace)
            case _:
                process.close()
                raise JobFailedError(
                    "the process sent what is no message of a job",
                    todo="look at the files of your own effects",
                )
    process.close()
    raise JobFailedError(
        "the work took too long", limit=f"{limit_s:g} s", todo="ask it of fewer shots"
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
