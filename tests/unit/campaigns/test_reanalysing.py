from __future__ import annotations

import json
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import pytest

from rigctl.errors import NotFoundError
from rigctl.jobs import JobFailedError, Task
from rigctl.measuring.reanalysing import analysed_before, reanalysis
from rigctl.store import ShotState, Store

Keep = Callable[..., list[str]]
PATIENCE_S = 60.0


def quiet() -> Task:
    return Task(lambda text, share: None)


def test_every_shot_is_handed_over_once_and_only_when_the_one_before_has_ended(
    store: Store, keep: Keep
) -> None:
    names = keep()
    under_way: list[str] = []
    order: list[str] = []
    said: list[float | None] = []
    pool = ThreadPoolExecutor(1)

    def analyse(shot: str) -> None:
        assert not under_way
        under_way.append(shot)
        order.append(shot)
        pool.submit(end, shot)

    def end(shot: str) -> None:
        store.move(shot, ShotState.ANALYSING)
        under_way.remove(shot)
        store.move(shot, ShotState.REFUSED if shot == names[1] else ShotState.ANALYSED)

    with pool:
        work = reanalysis(store, analyse, analysed_before(store, "nylon"), PATIENCE_S)
        result = work(Task(lambda text, share: said.append(share)))
    assert order == names
    assert json.loads(result) == {"shots": 4, "analysed": 3, "refused": 1}
    assert said == [0.0, 0.25, 0.5, 0.75]


def test_shots_that_wait_for_their_first_analysis_or_never_flew_are_left_out(
    store: Store, keep: Keep
) -> None:
    names = keep()
    store.move(names[0], ShotState.ANALYSING)
    store.move(names[1], ShotState.ANALYSING)
    store.move(names[1], ShotState.REFUSED)
    assert analysed_before(store, "nylon") == names[1:]


def test_a_campaign_without_an_ended_analysis_says_so(store: Store, keep: Keep) -> None:
    for shot in keep():
        store.move(shot, ShotState.ANALYSING)
    with pytest.raises(NotFoundError, match="no analysis of its shots has ended"):
        analysed_before(store, "nylon")


def test_cancelling_hands_no_further_shot_over(store: Store, keep: Keep) -> None:
    names, task, order = keep(), quiet(), list[str]()

    def analyse(shot: str) -> None:
        order.append(shot)
        task.cancel()

    with pytest.raises(JobFailedError, match="cancelled"):
        reanalysis(store, analyse, names, PATIENCE_S)(task)
    assert order == names[:1]


def test_an_analysis_that_never_ends_is_given_up_after_a_bound(store: Store, keep: Keep) -> None:
    names = keep()
    with pytest.raises(JobFailedError, match=f"shot {names[0]} does not end") as found:
        reanalysis(store, lambda shot: None, names, patience_s=0.05)(quiet())
    assert found.value.limit == "0.05 s without any change"
