"""Where shots are analysed: what is asked of a pool that is not there."""

from __future__ import annotations

import os
import socket
import sys

import pytest

from rigctl.errors import ConfigurationError
from rigctl.reanalysis import pool


def test_processes_of_this_host_work_with_one_thread_each(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "2")
    with pool(workers=1) as workshop:
        ask = workshop.executor.submit
        assert ask(os.getenv, "OPENBLAS_NUM_THREADS").result(60) == "1"
        assert ask(os.getpid).result(60) != os.getpid()
        assert workshop.workers() == 1


def test_a_scheduler_without_the_extra_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ConfigurationError, match="extra `dask`"), pool("tcp://127.0.0.1:1"):
        raise AssertionError("there is no pool")


@pytest.mark.filterwarnings("default")
def test_a_scheduler_that_does_not_answer_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("rigctl.reanalysis.pools.ANSWER_WAIT_S", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    with pytest.raises(ConfigurationError, match="no scheduler answers"), pool(address):
        raise AssertionError("there is no pool")
