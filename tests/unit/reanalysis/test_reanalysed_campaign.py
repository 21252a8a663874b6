"""A campaign analysed once more: results are added, and one shot that breaks stops nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rigctl.cameras.frames import FrameSequence
from rigctl.errors import NotFoundError
from rigctl.reanalysis import compared, reanalyse_campaign
from rigctl.settings import ShotSettings
from rigctl.store import Change, NewShot, ShotState, Store

Json = dict[str, Any]
NOW = datetime(2026, 1, 31, 12, tzinfo=UTC)
SETTINGS = ShotSettings(pressure_a_kpa=40.0, pressure_b_kpa=40.0, offset_mm=6.0)


class Inline(Executor):
    """Does the work at once, and counts it."""

    def __init__(self) -> None:
        self.done: list[str] = []

    def submit(self, call: Callable[..., Any], /, *given: Any, **named: Any) -> Future[Any]:
        future = Future[Any]()
        self.done.append(call.__name__)
        try:
            future.set_result(call(*given, **named))
        except Exception as error:  # noqa: BLE001 - it is told by the future
            future.set_exception(error)
        return future


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    opened = Store(tmp_path / "data")
    yield opened
    opened.close()


@pytest.fixture
def shots(store: Store) -> list[str]:
    """Three stored shots of a campaign, and one that misfired."""
    names = []
    for k in range(4):
        new = NewShot(SETTINGS, "nylon", None, "anna", True, "c0ffee", NOW)
        record, _ = store.accept(f"key {k}", "body", lambda new=new: new)
        store.move(record.id, ShotState.FIRING)
        if k == 3:
            store.move(record.id, ShotState.MISFIRE)
            continue
        store.move(record.id, ShotState.CAPTURING)
        pixels = np.full((2, 8, 8), k, dtype=np.uint8)
        frames = FrameSequence(pixels, np.arange(2) / 1e3, np.arange(2), (), "test")
        store.folders.write(record.id, frames, {"shot": record.id})
        store.move(record.id, ShotState.STORED, Change(frames=2))
        names.append(record.id)
    return names


@pytest.fixture
def answers(monkeypatch: pytest.MonkeyPatch) -> Callable[[Callable[[str, str], Json]], None]:
    """Let a function of a shot's name and the method stand in for the analysis."""

    def use(answer: Callable[[str, str], Json]) -> None:
        def analyse(folder: Path, method: str, known: None) -> Json:
            return answer(folder.name, method)

        monkeypatch.setattr("rigctl.stored_shot.analyse_stored_shot_as_taught", analyse)

    return use


def measured(e: float, sigma: float = 0.01) -> Json:
    return {"status": "measured", "e": {"value": e, "sigma": sigma, "unit": "1"}}


def silent(_text: str, _share: float | None) -> None:
    """Say nothing."""


def test_results_are_added_beside_those_there_are(
    store: Store, shots: list[str], answers: Any
) -> None:
    answers(lambda shot, method: measured(0.7))
    first = reanalyse_campaign(store, "nylon", "thesis", Inline(), silent)
    answers(lambda shot, method: measured(0.8))
    second = reanalyse_campaign(store, "nylon", "thesis", Inline(), silent)
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
    reanalyse_campaign(store, "nylon", "thesis", Inline(), silent)

    def breaks(shot: str, method: str) -> Json:
        if shot == shots[1]:
            raise ValueError("no such thing")
        return measured(0.8)

    answers(breaks)
    outcomes = reanalyse_campaign(store, "nylon", "thesis", Inline(), silent)
    assert [outcome.failure for outcome in outcomes] == [None, "ValueError: no such thing", None]
    assert [store.shot(shot).results for shot in shots] == [2, 1, 2]
    assert store.shot(shots[1]).state is ShotState.ANALYSED


def test_a_refused_shot_says_why(store: Store, shots: list[str], answers: Any) -> None:
    refusal = {"status": "refused", "step": "markers", "reason": "only one marker"}
    answers(lambda shot, method: refusal)
    outcomes = reanalyse_campaign(store, "nylon", "thesis", Inline(), silent)
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
    outcomes = reanalyse_campaign(store, "nylon", "thesis", Inline(), silent)
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
    reanalyse_campaign(store, "nylon", "thesis", Inline(), silent)
    assert taught == []
    reanalyse_campaign(store, "nylon", "photometric", Inline(), silent)
    assert taught == [shots]


def test_a_campaign_without_frames_is_refused(store: Store, shots: list[str]) -> None:
    with pytest.raises(NotFoundError, match="no such campaign"):
        reanalyse_campaign(store, "brass", "thesis", Inline(), silent)
    for shot in shots:
        store.move(shot, ShotState.ANALYSING)
    with pytest.raises(NotFoundError, match="nobody is analysing"):
        reanalyse_campaign(store, "nylon", "thesis", Inline(), silent)


def test_results_are_compared_quantity_by_quantity(
    store: Store, shots: list[str], answers: Any
) -> None:
    answers(lambda shot, method: measured(0.7, sigma=0.03))
    reanalyse_campaign(store, "nylon", "thesis", Inline(), silent)
    later = dict(zip(shots, (0.75, 0.70, 0.65), strict=True))
    answers(lambda shot, method: measured(later[shot], sigma=0.04))
    (change,) = compared(reanalyse_campaign(store, "nylon", "thesis", Inline(), silent))
    assert (change.quantity, change.unit, change.shots) == ("e", "1", 3)
    assert change.mean == pytest.approx(0.0, abs=1e-12)
    assert change.rms == pytest.approx((2 * 0.05**2 / 3) ** 0.5)
    assert change.rms_sigmas == pytest.approx((2 / 3) ** 0.5)


def test_without_a_result_before_there_is_nothing_to_compare(
    store: Store, shots: list[str], answers: Any
) -> None:
    answers(lambda shot, method: measured(0.7))
    assert compared(reanalyse_campaign(store, "nylon", "thesis", Inline(), silent)) == []
