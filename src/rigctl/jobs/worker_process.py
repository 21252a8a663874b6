"""A process that does what it is ordered: a job, or one shot's analysis after another.

It is killed with whatever it started. It has an environment of its own and nothing of the
daemon's, for it may run the files of own effects; `rigctl.jobs.worker` is its other end.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path

from rigctl.documents import Json
from rigctl.jobs.failure import JobFailedError

END_WAIT_S = 5.0
NICENESS = 19
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


@dataclass(frozen=True, slots=True)
class Conditions:
    """What a process is started under: files that are hidden from it, and whether it has the net.

    `loads` are modules that it imports before it is asked for anything.
    """

    hidden: tuple[Path, ...]
    network: bool
    loads: tuple[str, ...] = ()


def conditions(*, network: bool, loads: tuple[str, ...] = ()) -> Conditions:
    """Return what a process that starts now is started under."""
    return Conditions(tuple(sorted(_hidden)), network, loads)


class WorkerProcess:
    """A process that waits for an order, does it and answers, and waits for the next.

    Parameters
    ----------
    under
        What it is kept from, and what it loads first.
    niceness
        How far it stands back behind the daemon, from 0 to 19.

    Raises
    ------
    JobFailedError
        It cannot be started.
    """

    def __init__(self, under: Conditions, niceness: int = NICENESS) -> None:
        self.under = under
        self._process, self.connection = _start()
        if niceness:
            with suppress(OSError):
                os.setpriority(os.PRIO_PROCESS, self._process.pid, niceness)
        hidden = [str(path) for path in under.hidden]
        self._write(
            {"path": sys.path, "hidden": hidden, "network": under.network, "loads": under.loads}
        )

    @property
    def pid(self) -> int:
        """Number of the process."""
        return self._process.pid

    @property
    def alive(self) -> bool:
        """Whether it runs."""
        return self._process.poll() is None

    def order(self, function: str, arguments: Json) -> None:
        """Have it call a function `module:name` with a JSON object; its answer comes by the pipe.

        One that is gone already is seen at the pipe.
        """
        self._write({"function": function, "arguments": arguments})

    def close(self) -> None:
        """Kill the process with all that it has started in its session, and close the pipe."""
        self.kill()
        self._wait()
        self.connection.close()
        if self._process.stdin is not None:
            with suppress(OSError):
                self._process.stdin.close()

    def kill(self) -> None:
        """Kill it while another thread reads its pipe."""
        with suppress(ProcessLookupError):
            if self._process.returncode is None:
                os.killpg(self._process.pid, signal.SIGKILL)

    def end_in_words(self) -> str:
        """Say how it ended, once it has."""
        self._wait()
        code = self._process.returncode
        if code is not None and code < 0:
            return f"was killed by {signal.Signals(-code).name}"
        return f"ended with status {code}"

    def _wait(self) -> None:
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(END_WAIT_S)

    def _write(self, line: Json) -> None:
        if self._process.stdin is not None:
            with suppress(OSError):
                self._process.stdin.write(json.dumps(line).encode() + b"\n")
                self._process.stdin.flush()


def _start() -> tuple[subprocess.Popen[bytes], Connection]:
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
    return process, ours


def _environment() -> dict[str, str]:
    passed = {name: os.environ[name] for name in PASSED_ON if name in os.environ}
    return passed | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "PYTHONSAFEPATH": "1"}
