"""Items are worked on in threads, a few at a time, with results in their order."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator

import pytest

from analysis import threads
from analysis.workers import Workers


@pytest.fixture(autouse=True)
def _two_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(threads.VARIABLE, "2")


def test_results_come_in_the_order_of_the_items_whichever_is_ready_first() -> None:
    second_done = threading.Event()

    def waits(item: int) -> int:
        if item == 0:
            assert second_done.wait(30)
        if item == 1:
            second_done.set()
        return 10 * item

    assert list(threads.each(waits, range(5))) == [0, 10, 20, 30, 40]


def test_two_items_are_worked_on_at_once() -> None:
    both = threading.Barrier(2, timeout=30)
    assert len(list(threads.each(lambda _: both.wait(), range(4)))) == 4


def test_few_items_are_taken_before_a_result_is() -> None:
    taken = []

    def pictures() -> Iterator[int]:
        for number in range(1000):
            taken.append(number)
            yield number

    results = threads.each(abs, pictures())
    assert next(results) == 0
    assert len(taken) <= 2 * threads.AHEAD
    results.close()  # type: ignore[attr-defined]


def test_what_the_function_raises_is_raised_and_later_items_are_not_taken() -> None:
    left = iter(range(1000))
    with pytest.raises(ZeroDivisionError):
        list(threads.each(lambda item: 1 // (item - 3), left))
    assert next(left) < 20


def test_what_the_items_raise_is_raised() -> None:
    def broken() -> Iterator[int]:
        yield 1
        raise OSError("the film ends here")

    with pytest.raises(OSError, match="the film ends here"):
        list(threads.each(abs, broken()))


def test_one_thread_is_the_callers_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(threads.VARIABLE, "1")
    names = set(threads.each(lambda _: threading.current_thread().name, range(3)))
    assert names == {threading.current_thread().name}


@pytest.mark.parametrize("stated", ["", "0", "many", "-2"])
def test_there_is_one_thread_at_least(stated: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(threads.VARIABLE, stated)
    assert threads.count() >= 1


@pytest.mark.parametrize(("threads_here", "processes", "each"), [(8, 2, "4"), (2, 3, "1")])
def test_processes_share_the_threads(
    threads_here: int, processes: int, each: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(threads.VARIABLE, str(threads_here))
    with Workers(processes) as workers:
        assert workers.submit(os.getenv, threads.VARIABLE).result(60) == each
