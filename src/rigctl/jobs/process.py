"""Work in a process of its own, of low priority: it can be killed, and firing never waits for it.

A process serves one job. Its start costs a second; a worker shared between jobs would hand the
memory and the faults of one to the next. It may run the files of own effects, and so has an
environment of its own and nothing of the daemon's (`enclosure`).
"""

from __future__ import annotations

import json
import logging
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path

from rigctl.documents import Json
from rigctl.jobs.task import JobFailedError, Task, Work

_log = logging.getLogger(__name__)

LONGEST_S = 3600.0
END_WAIT_S = 5.0
NICENESS = 19
MOST_BYTES = 64 * 1024**2
"""Of one message of a job, its result with it."""
PASSED_ON = (
    *("HOME", "LANG", "LANGUAGE", "PATH", "TMPDIR", "TZ", "USER", "VIRTUAL_ENV"),
    *("LD_LIBRARY_PATH", "PYTHONHASHSEED", "PYTHONPATH", "PYTHONPYCACHEPREFIX", "RIGCTL_FILES"),
    *("MPLCONFIGDIR", "NUMBA_CACHE_DIR", "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"),
    *("XDG_CACHE_HOME", "LC_ALL", "LC_CTYPE", "LC_NUMERIC", "LC_TIME"),
)
"""Variables of the daemon's environment that a job has: none of them holds a secret."""


_hidden: set[Path] = set()


def hide_from_jobs(path: Path) -> None:
    """Let jobs that start from now on find nothing in a file, where the kernel allows that."""
    _hidden.add(path.absolute())


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
        process, connection = _start(function, arguments)
        with connection, process:
            try:
                task.on_cancel(lambda: _kill(process))
                return _attend(process, connection, task, longest_s)
            finally:
                _kill(process)

    return work


def _attend(
    process: subprocess.Popen[bytes], connection: Connection, task: Task, longest_s: float
) -> str:
    ends_at = time.monotonic() + longest_s
    while connection.poll(max(0.0, ends_at - time.monotonic())):
        try:
            message = connection.recv_bytes(MOST_BYTES)
        except (EOFError, OSError) as error:
            raise JobFailedError(
                f"the process {_end_of(process)}", todo="look at the host's memory, then ask again"
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


def _start(function: str, arguments: Json) -> tuple[subprocess.Popen[bytes], Connection]:
    """Start the process and return it with this end of its pipe."""
    order = {
        "function": function,
        "arguments": arguments,
        "path": sys.path,
        "hidden": sorted(map(str, _hidden)),
        "network": arguments.get("database") is not None,
    }
    ours, theirs = Pipe(duplex=False)
    # Only the process may hold its end, or its death would not be seen.
    with theirs:
        try:
            process = subprocess.Popen(  # noqa: S603 - no word of it comes from outside
                [sys.executable, "-P", "-m", "rigctl.jobs.worker", str(theirs.fileno())],
                stdin=subprocess.PIPE,
                pass_fds=(theirs.fileno(),),
                env=_environment(),
                start_new_session=True,
            )
        except Exception as error:
            ours.close()
            raise JobFailedError(
                f"the process could not be started: {error}",
                todo="free memory or processes on the host, then ask again",
            ) from error
    with suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, process.pid, NICENESS)
    if process.stdin is not None:
        # One that is gone already is seen at the pipe.
        with suppress(OSError):
            process.stdin.write(json.dumps(order).encode() + b"\n")
            process.stdin.flush()
    return process, ours


def _environment() -> dict[str, str]:
    passed = {name: os.environ[name] for name in PASSED_ON if name in os.environ}
    return passed | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "PYTHONSAFEPATH": "1"}


def _kill(process: subprocess.Popen[bytes]) -> None:
    """Kill the process with all that it has started in its session."""
    with suppress(ProcessLookupError):
        if process.returncode is None:
            os.killpg(process.pid, signal.SIGKILL)
    with suppress(subprocess.TimeoutExpired):
        process.wait(END_WAIT_S)


def _end_of(process: subprocess.Popen[bytes]) -> str:
    with suppress(subprocess.TimeoutExpired):
        process.wait(END_WAIT_S)
    code = process.returncode
    if code is not None and code < 0:
        return f"was killed by {signal.Signals(-code).name}"
    return f"ended with status {code}"
