"""A campaign analysed once more: results are added, and one shot that breaks stops nothing."""

from __future__ import annotations

import gc
import math
import weakref
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from rigctl.errors import NotFoundError
from rigctl.reanalysis import Comparison, Comparisons, Outcome, Pool, reanalyse_campaign
from rigctl.reanalysis.pools import AHEAD
from rigctl.store import ShotState, Store
from tests.unit.reanalysis.stored_campaign import (
    Inline,
    measured,
    reanalysed,
    silent,
    stored,
)

Json = dict[str, Any]


def compared(outcomes: Iterable[Outcome]) -> list[Comparison]:
    comparisons = Comparisons()
    for outcome in outcomes:
        comparisons.add(outcome)
    return comparisons.found()


def test_results_are_added_beside_those_there_are(
    store: Store, shots: list[str], answers: Any
) -> None:
    answers(lambda shot, method: measured(0.7))
    first = reanalysed(store, "nylon", "thesis")
    answers(lambda shot, method: measured(0.8))
    second = reanalysed(store, "nylon", "thesis")
    assert [outcome.shot.id for outcome in second] == shots
    assert all(outcome.before is None for outcome in first)
    for shot in shots:
        assert store.shot(shot).state is ShotState.ANALYSED
        assert store.shot(shot).results == 2
        assert store.result(shot, 1)["e"]["value"] == 0.7
        assert store.result(shot, 2)["e"]["value"] == 0.8


def test_a_shot_that_breaks_keeps_what_it_has_and_the_others_go_on(
    store: Store, shots: list[str], answers: Any
) -> None:
    answers(lambda shot, method: measured(0.7))
    reanalysed(store, "nylon", "thesis")

    def breaks(shot: str, method: str) -> Json:
        if shot == shots[1]:
            raise ValueError("no such thing")
        return measured(0.8)

    answers(breaks)
    outcomes = reanalysed(store, "nylon", "thesis")
    assert [outcome.failure for outcome in outcomes] == [None, "ValueError: no such thing", None]
    assert [store.shot(shot).results for shot in shots] == [2, 1, 2]
    assert store.shot(shots[1]).state is ShotState.ANALYSED


def test_a_refused_shot_says_why(store: Store, shots: list[str], answers: Any) -> None:
    refusal = {"status": "refused", "step": "markers", "reason": "only one marker"}
    answers(lambda shot, method: refusal)
    outcomes = reanalysed(store, "nylon", "thesis")
    assert {outcome.shot.state for outcome in outcomes} == {ShotState.REFUSED}
    assert store.shot(shots[0]).failure == "only one marker"


def test_a_shot_that_a_daemon_analyses_is_left_to_it(
    store: Store, shots: list[str], answers: Any
) -> None:
    store.move(shots[0], ShotState.ANALYSING)

    def taken_meanwhile(shot: str, method: str) -> Json:
        if shot == shots[1]:
            store.move(shot, ShotState.ANALYSING)
        return measured(0.7)

    answers(taken_meanwhile)
    outcomes = reanalysed(store, "nylon", "thesis")
    assert [outcome.shot.id for outcome in outcomes] == shots[1:]
    assert "analysing cannot become analysing" in str(outcomes[0].failure)
    assert [store.shot(shot).results for shot in shots] == [0, 0, 1]


def test_only_the_photometric_method_learns_first(
    store: Store, shots: list[str], answers: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    taught: list[list[str]] = []

    def teach(folders: list[Path]) -> None:
        taught.append([folder.name for folder in folders])

    monkeypatch.setattr("rigctl.reanalysis.campaign.taught", teach)
    answers(lambda shot, method: measured(0.7))
    reanalysed(store, "nylon", "thesis")
    assert taught == []
    reanalysed(store, "nylon", "photometric")
    assert taught == [shots]


def test_a_campaign_without_frames_is_refused(store: Store, shots: list[str]) -> None:
    with pytest.raises(NotFoundError, match="no such campaign"):
        reanalysed(store, "brass", "thesis")
    for shot in shots:
        store.move(shot, ShotState.ANALYSING)
    with pytest.raises(NotFoundError, match="nobody is analysing"):
        reanalysed(store, "nylon", "thesis")


def test_results_are_compared_quantity_by_quantity(
    store: Store, shots: list[str], answers: Any
) -> None:
    answers(lambda shot, method: measured(0.7, sigma=0.03))
    reanalysed(store, "nylon", "thesis")
    later = dict(zip(shots, (0.75, 0.70, 0.65), strict=True))
    answers(lambda shot, method: measured(later[shot], sigma=0.04))
    (change,) = compared(reanalysed(store, "nylon", "thesis"))
    assert (change.quantity, change.unit, change.shots) == ("e", "1", 3)
    assert change.mean == pytest.approx(0.0, abs=1e-12)
    assert change.rms == pytest.approx((2 * 0.05**2 / 3) ** 0.5)
    assert change.rms_sigmas == pytest.approx((2 / 3) ** 0.5)


def test_an_error_without_bound_counts_as_not_stated_where_results_are_compared(
    store: Store, shots: list[str], answers: Any
) -> None:
    answers(lambda shot, method: measured(0.7, sigma=None))
    reanalysed(store, "nylon", "thesis")
    answers(lambda shot, method: measured(0.8, sigma=0.04))
    (change,) = compared(reanalysed(store, "nylon", "thesis"))
    assert change.mean == pytest.approx(0.1)
    assert change.rms_sigmas is None


def test_without_a_result_before_there_is_nothing_to_compare(
    store: Store, shots: list[str], answers: Any
) -> None:
    answers(lambda shot, method: measured(0.7))
    assert compared(reanalysed(store, "nylon", "thesis")) == []


class Result(dict[str, Any]):
    """A result whose end is seen."""

    __hash__ = object.__hash__  # type: ignore[assignment]


@pytest.fixture
def nothing_older() -> Iterator[None]:
    """Keep what was there before a test out of its collections: all of it is gone through."""
    gc.collect()
    gc.freeze()
    yield
    gc.unfreeze()


class Watching(Inline):
    """Sees how many results anybody still holds when the next is asked for."""

    def __init__(self) -> None:
        super().__init__()
        self.alive = weakref.WeakSet[Result]()
        self.most = 0

    def submit(self, call: Callable[..., Any], /, *given: Any, **named: Any) -> Future[Any]:
        # Only what somebody still holds is to be counted.
        gc.collect()
        self.most = max(self.most, len(self.alive) + 1)
        (found,) = super().submit(call, *given, **named).result()
        self.alive.add(brief := Result(found.brief))
        future = Future[Any]()
        future.set_result([replace(found, brief=brief)])
        return future


@pytest.mark.usefixtures("nothing_older")
def test_few_results_are_held_however_many_shots_there_are(store: Store, answers: Any) -> None:
    answers(lambda shot, method: measured(0.7))
    shots = [stored(store) for _ in range(5 * AHEAD)]
    executor = Watching()
    pool = Pool(executor, lambda: 1)
    names = [
        outcome.shot.id for outcome in reanalyse_campaign(store, "nylon", "thesis", pool, silent)
    ]
    assert names == shots
    assert AHEAD <= executor.most <= AHEAD + 2


def test_poses_are_in_the_file_and_not_in_what_is_compared(
    store: Store, shots: list[str], answers: Any
) -> None:
    answers(lambda shot, method: {**measured(0.7), "poses": [1.0], "overlay": {"frames": []}})
    outcomes = reanalysed(store, "nylon", "thesis")
    assert [outcome.after for outcome in outcomes] == [measured(0.7)] * 3
    assert store.result(shots[0]) == {**measured(0.7), "poses": [1.0], "overlay": {"frames": []}}


def test_a_number_that_is_not_finite_is_said_and_not_stored(
    store: Store, shots: list[str], answers: Any
) -> None:
    answers(lambda shot, method: measured(math.nan if shot == shots[0] else 0.7))
    outcomes = reanalysed(store, "nylon", "thesis")
    assert "not JSON compliant" in str(outcomes[0].failure)
    assert [store.shot(shot).results for shot in shots] == [0, 1, 1]


def test_a_shot_is_stored_before_the_last_is_begun(store: Store, answers: Any) -> None:
    shots = [stored(store) for _ in range(AHEAD + 2)]
    results_at_begin: list[int] = []

    def answer(shot: str, method: str) -> Json:
        results_at_begin.append(sum(store.shot(name).results for name in shots))
        return measured(0.7)

    answers(answer)
    reanalysed(store, "nylon", "thesis")
    assert results_at_begin == [0] * AHEAD + [1, 2]


class Counting(Inline):
    """Notes how many shots each task has."""

    def __init__(self) -> None:
        super().__init__()
        self.sizes: list[int] = []

    def submit(self, call: Callable[..., Any], /, *given: Any, **named: Any) -> Future[Any]:
        self.sizes.append(len(given[0]))
        return super().submit(call, *given, **named)


def test_shots_go_to_a_cluster_several_at_a_time_and_singly_toward_the_end(
    store: Store, answers: Any
) -> None:
    shots = [stored(store) for _ in range(12)]
    answers(lambda shot, method: measured(float(shot[-2:])))
    executor = Counting()
    pool = Pool(executor, lambda: 1, together=4)
    outcomes = list(reanalyse_campaign(store, "nylon", "thesis", pool, silent))
    assert [outcome.shot.id for outcome in outcomes] == shots
    assert [store.result(shot)["e"]["value"] for shot in shots] == [*range(1, 13)]
    assert executor.sizes == [4, 4, 2, 1, 1]


def test_a_shot_that_breaks_stops_no_other_of_its_task(
    store: Store, shots: list[str], answers: Any
) -> None:
    def breaks(shot: str, method: str) -> Json:
        if shot == shots[0]:
            raise ValueError("no such thing")
        return measured(0.8)

    answers(breaks)
    pool = Pool(Inline(), lambda: 1, together=2)
    outcomes = list(reanalyse_campaign(store, "nylon", "thesis", pool, silent))
    assert [outcome.failure for outcome in outcomes] == ["ValueError: no such thing", None, None]


def test_a_task_that_is_lost_costs_its_own_shots_alone(
    store: Store, shots: list[str], answers: Any
) -> None:
    class Losing(Inline):
        def submit(self, call: Callable[..., Any], /, *given: Any, **named: Any) -> Future[Any]:
            if self.done:
                return super().submit(call, *given, **named)
            self.done.append("lost")
            future = Future[Any]()
            future.set_exception(OSError("the worker died"))
            return future

    answers(lambda shot, method: measured(0.7))
    pool = Pool(Losing(), lambda: 1, together=2)
    outcomes = list(reanalyse_campaign(store, "nylon", "thesis", pool, silent))
    lost = "OSError: the worker died"
    assert [outcome.failure for outcome in outcomes] == [lost, lost, None]
    assert [store.shot(shot).results for shot in shots] == [0, 0, 1]


def test_shots_that_are_fired_meanwhile_are_left_for_the_next_time(
    store: Store, shots: list[str], answers: Any
) -> None:
    def answer(shot: str, method: str) -> Json:
        stored(store)
        return measured(0.7)

    answers(answer)
    assert [outcome.shot.id for outcome in reanalysed(store, "nylon", "thesis")] == shots
