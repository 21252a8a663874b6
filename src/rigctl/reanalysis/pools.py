"""Where shots are analysed: processes of this host, or the workers of a Dask cluster.

Both are executors of the standard library's kind, so that the same code runs on either.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context

from rigctl.errors import ConfigurationError

ANSWER_WAIT_S = 10.0
"""Longest wait for a scheduler's first answer."""

_ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


@contextmanager
def pool(scheduler: str | None = None, workers: int | None = None) -> Iterator[Executor]:
    """Give an executor; what it has not begun is cancelled when the block ends early.

    Parameters
    ----------
    scheduler
        Address of a Dask scheduler; None: processes of this host.
    workers
        How many processes of this host; None: one for each processor.

    Raises
    ------
    ConfigurationError
        The extra `dask` is not installed, or no scheduler answers there.
    """
    if scheduler is None:
        executor: Executor = ProcessPoolExecutor(
            workers or os.cpu_count() or 1, mp_context=get_context("spawn"), initializer=_begin
        )
        try:
            yield executor
        finally:
            executor.shutdown(wait=True, cancel_futures=True)
        return
    with _cluster(scheduler) as executor:
        yield executor


@contextmanager
def _cluster(address: str) -> Iterator[Executor]:
    try:
        # An extra that few installations have, and slow to load.
        from distributed import Client  # noqa: PLC0415
    except ImportError as error:
        raise ConfigurationError(
            f"needs what is not installed: {error}",
            part="scheduler",
            todo="install rigctl with the extra `dask`",
        ) from error
    try:
        client = Client(address, timeout=ANSWER_WAIT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ConfigurationError(
            f"no scheduler answers: {error}",
            part="scheduler",
            value=repr(address),
            limit=f"{ANSWER_WAIT_S:g} s",
            todo="start one with `dask scheduler` and workers with `dask worker ADDRESS`",
        ) from error
    with client:
        executor: Executor = client.get_executor(pure=False, retries=0)
        try:
            yield executor
        finally:
            # The cluster's executor cancels what it is not to wait for.
            executor.shutdown(wait=False)


def _begin() -> None:
    """Prepare a process: one thread each, or sums would depend on how many there are."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # Read when the libraries are loaded, which the first shot does.
    os.environ.update(dict.fromkeys(_ONE_THREAD, "1"))
