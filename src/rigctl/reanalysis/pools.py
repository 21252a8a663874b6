"""Where shots are analysed: processes of this host, or the workers of a Dask cluster.

Both are executors of the standard library's kind, so that the same code runs on either.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass

from analysis.workers import Workers
from rigctl.errors import ConfigurationError

ANSWER_WAIT_S = 10.0
"""Longest wait for a scheduler's first answer."""

AHEAD = 4
"""Tasks under way for each worker, so that none waits for the next while results are stored."""

TOGETHER = 8
"""Shots that a cluster's worker is given at a time: a task costs scheduler, network and client
some milliseconds of a processor, however short it is."""

_ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""Environment of each process: sums would depend on how many threads there are."""


@dataclass(frozen=True, slots=True)
class Pool:
    """Where shots are analysed.

    Attributes
    ----------
    executor
        Does what is submitted.
    workers
        Returns how many there are now: those of a cluster come and go.
    together
        Most shots that are given to a worker as one task; no more results are held at any time
        than these for each of the tasks under way.
    """

    executor: Executor
    workers: Callable[[], int]
    together: int = 1

    @property
    def ahead(self) -> int:
        """How many tasks are to be under way, so that no worker waits for the next."""
        return AHEAD * max(self.workers(), 1)

    def share(self, left: int) -> int:
        """Return how many of the shots that are left make the next task.

        Fewer toward the end, so that no worker is left with many when the others have none.
        """
        return min(self.together, max(left // (2 * max(self.workers(), 1)), 1))


@contextmanager
def pool(scheduler: str | None = None, workers: int | None = None) -> Iterator[Pool]:
    """Yield a pool; tasks not yet begun are cancelled when the block ends early.

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
        count = workers or os.cpu_count() or 1
        with Workers(count, _ONE_THREAD) as executor:
            yield Pool(executor, lambda: count)
        return
    with _cluster(scheduler) as cluster:
        yield cluster


@contextmanager
def _cluster(address: str) -> Iterator[Pool]:
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
            yield Pool(executor, lambda: sum(client.nthreads().values()), TOGETHER)
        finally:
            # The cluster's executor cancels the tasks that are not awaited.
            executor.shutdown(wait=False)
