"""Processes that compute for a script or a notebook, whatever that is made of.

The pool of the standard library runs its caller's script once more in each process, so that one
without `if __name__ == "__main__":` starts pools without end, or breaks. The processes here run
this file alone; what they compute is named by its module.
"""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor
from contextlib import suppress
from typing import IO, Any, ParamSpec, TypeVar

from analysis import threads

P = ParamSpec("P")
R = TypeVar("R")

START = (
    "import pickle, sys; sys.path[:] = pickle.load(sys.stdin.buffer); "
    "from analysis.workers import serve; serve()"
)
SIZE_BYTES = 8
"""Size of the number before each message that states its length."""
END_WAIT_S = 5.0


class WorkerDiedError(BrokenExecutor):
    """A worker process ended without a result: by a signal, or because memory ran out."""


class Workers(Executor):
    """So many processes, started as they are needed and ended with the `with` block.

    Functions, arguments and results are pickled: a function must stand at the top of a module that
    can be imported. A process that dies costs the one result under way; the next has another.

    Parameters
    ----------
    count
        Most processes at a time.
    environment
        Variables that each process has besides, or in the place of, those of this one.
    """

    def __init__(self, count: int, environment: Mapping[str, str] | None = None) -> None:
        # Beside other processes more threads wait for each other, at full load.
        own = str(max(1, threads.count() // count))
        few = {"OPENBLAS_NUM_THREADS": "1", **os.environ, threads.VARIABLE: own}
        self._environment = few | dict(environment or {})
        self._threads = ThreadPoolExecutor(count, thread_name_prefix="worker")
        self._own = threading.local()
        self._lock = threading.Lock()
        self._started: list[_Worker] = []

    def __exit__(self, *_: object) -> None:
        self.shutdown()

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = True) -> None:
        """Kill the processes, whatever they are at; what is not computed is cancelled or broken."""
        del wait, cancel_futures
        self._threads.shutdown(wait=False, cancel_futures=True)
        with self._lock:
            for worker in self._started:
                worker.end()
        self._threads.shutdown()
        for worker in self._started:
            worker.close()

    def submit(self, function: Callable[P, R], /, *args: P.args, **named: P.kwargs) -> Future[R]:
        """Compute in one of the processes.

        Returns
        -------
        A future that raises what the function raises, or `WorkerDiedError`.
        """
        return self._threads.submit(lambda: self._ask(function, *args, **named))

    def _ask(self, function: Callable[P, R], *args: P.args, **named: P.kwargs) -> R:
        worker: _Worker | None = getattr(self._own, "worker", None)
        if worker is None or worker.ended:
            worker = self._own.worker = _Worker(self._environment)
            with self._lock:
                self._started.append(worker)
        done, answer = worker.call((function, args, named))
        if not done:
            raise answer
        result: R = answer
        return result


class _Worker:
    """One worker process, used by one thread."""

    def __init__(self, environment: Mapping[str, str]) -> None:
        self._process = subprocess.Popen(  # noqa: S603 - no outside input
            [sys.executable, "-P", "-c", START],
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        assert self._process.stdin is not None  # noqa: S101 - both are pipes
        assert self._process.stdout is not None  # noqa: S101
        self._requests, self._answers = self._process.stdin, self._process.stdout
        pickle.dump(sys.path, self._requests)

    @property
    def ended(self) -> bool:
        return self._process.poll() is not None

    def call(self, request: object) -> tuple[bool, Any]:
        try:
            _send(self._requests, pickle.dumps(request))
            answer: tuple[bool, Any] = pickle.loads(_received(self._answers))  # noqa: S301 - ours
        except (EOFError, OSError) as error:
            self.end()
            raise WorkerDiedError(
                f"a process that analyses ended with status {self._process.returncode} before it "
                "had answered; look at the memory that is free, then ask again"
            ) from error
        return answer

    def end(self) -> None:
        self._process.kill()
        self._process.wait(END_WAIT_S)

    def close(self) -> None:
        """Give back both pipes, once no thread reads or writes any more."""
        self.end()
        with suppress(OSError):
            self._requests.close()
        self._answers.close()


def serve() -> None:
    """Answer the requests on standard input until it is closed.

    What a function prints goes to standard error: standard output holds answers alone.
    """
    # An interruption is for the caller, who ends its processes.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with os.fdopen(os.dup(1), "wb") as answers:
        os.dup2(2, 1)
        while True:
            try:
                request = _received(sys.stdin.buffer)
            except EOFError:
                return
            _send(answers, _reply(request))


def _reply(request: bytes) -> bytes:
    try:
        function, args, named = pickle.loads(request)  # noqa: S301 - from the parent
        return pickle.dumps((True, function(*args, **named)))
    except Exception as error:  # noqa: BLE001 - raised again in the calling process
        try:
            whole = pickle.dumps((False, error))
            pickle.loads(whole)  # noqa: S301 - some exceptions are written and cannot be read
        except Exception:  # noqa: BLE001
            whole = pickle.dumps((False, RuntimeError(f"{type(error).__name__}: {error}")))
        return whole


def _send(stream: IO[bytes], message: bytes) -> None:
    stream.write(len(message).to_bytes(SIZE_BYTES, "big"))
    stream.write(message)
    stream.flush()


def _received(stream: IO[bytes]) -> bytes:
    """Return the next message; `EOFError` where the other side is gone."""
    size = stream.read(SIZE_BYTES)
    if len(size) < SIZE_BYTES:
        raise EOFError
    length = int.from_bytes(size, "big")
    message = stream.read(length)
    if len(message) < length:
        raise EOFError
    return message
