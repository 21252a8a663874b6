"""Analysis in processes of their own: results beside the frames, crashes that harm nobody."""

from __future__ import annotations

import logging
import subprocess
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from rig_fakes import BOUND_S, Laboratory, until

from rigctl.errors import StoreError
from rigctl.jobs import attending
from rigctl.jobs.worker_process import WorkerProcess
from rigctl.measuring.analysing import Analyser, AnalysisProcess, Awaited
from rigctl.measuring.result_keeping import Keeper
from rigctl.measuring.stored_shot import analyse_stored_shot, manifest_setup
from rigctl.store import ShotRecord, Store

DONE = {"analysed", "refused"}


class Outcomes:
    """Collects how analyses end, and lets a test wait for so many of them."""

    def __init__(self, store: Store) -> None:
        self.records = {}
        self._changed = threading.Condition()
        store.listeners.add(self._hear)

    def _hear(self, record: ShotRecord) -> None:
        if record.state in DONE:
            with self._changed:
                self.records[record.id] = record
                self._changed.notify_all()

    def wait(self, shots: int) -> list[ShotRecord]:
        with self._changed:
            assert self._changed.wait_for(lambda: len(self.records) >= shots, 60.0)
        return [self.records[name] for name in sorted(self.records)]


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Laboratory]:
    laboratory = Laboratory(tmp_path / "data")
    yield laboratory
    laboratory.close()


@pytest.fixture
def analysed(
    lab: Laboratory, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> Iterator[Callable[..., list[ShotRecord]]]:
    """Return what becomes of so many shots under a stand-in analysis."""
    monkeypatch.syspath_prepend(request.path.parent)
    outcomes, opened = Outcomes(lab.store), []

    def run(
        function: str,
        *,
        shots: int = 1,
        ends: int | None = None,
        workers: int = 1,
        timeout_s: float = 60.0,
    ) -> list[ShotRecord]:
        analyser = Analyser(
            lab.store,
            workers=workers,
            method="thesis",
            timeout_s=timeout_s,
            function=f"stand_in_analysis:{function}",
        )
        opened.append(analyser)
        for _ in range(shots):
            analyser.submit(lab.shoot().id)
        return outcomes.wait(shots if ends is None else ends)

    yield run
    for analyser in opened:
        analyser.close()


def test_a_result_is_written_beside_the_frames_and_the_row_follows(
    lab: Laboratory, analysed: Callable[..., list[ShotRecord]]
) -> None:
    (shot,) = analysed("measured")
    assert (shot.state, shot.outcome, shot.results) == ("analysed", "stored", 1)
    assert lab.store.result(shot.id) == {
        "status": "measured",
        "shot": shot.id,
        "method": "thesis",
    }


def test_a_refusal_is_a_result_with_its_reason_in_the_row(
    lab: Laboratory, analysed: Callable[..., list[ShotRecord]]
) -> None:
    (shot,) = analysed("refused")
    assert (shot.state, shot.failure, shot.results) == ("refused", "only 2 markers", 1)
    assert lab.store.result(shot.id)["step"] == "markers"


@pytest.mark.parametrize(
    ("function", "words"),
    [
        ("broken", "ValueError: a bug"),
        ("not_finite", "ValueError"),
        ("absent", "AttributeError: module"),
    ],
)
def test_an_analysis_that_breaks_is_told_and_leaves_no_result(
    lab: Laboratory, analysed: Callable[..., list[ShotRecord]], function: str, words: list[str]
) -> None:
    (shot,) = analysed(function)
    assert (shot.state, shot.failure_code, shot.results) == ("refused", "analysis-failed", 0)
    assert words in shot.failure


def test_a_crash_is_that_of_its_shot_alone_and_the_worker_is_replaced(
    lab: Laboratory, analysed: Callable[..., list[ShotRecord]]
) -> None:
    crashed, *others = analysed("crashes_at_the_first", shots=3)
    assert crashed.state == "refused"
    assert "killed by SIGSEGV" in crashed.failure
    assert [shot.state for shot in others] == ["analysed", "analysed"]


def test_an_analysis_without_end_is_ended(analysed: Callable[..., list[ShotRecord]]) -> None:
    (shot,) = analysed("never_ends", timeout_s=0.05)
    assert (shot.state, shot.failure_code) == ("refused", "analysis-failed")
    assert "took too long (limit 0.05 s)" in shot.failure


def test_an_analysis_that_is_cancelled_ends_at_once_and_the_next_shot_is_analysed(
    lab: Laboratory, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    monkeypatch.syspath_prepend(request.path.parent)
    outcomes, function = Outcomes(lab.store), "stand_in_analysis:compiles_first"
    analyser = Analyser(lab.store, workers=1, method="thesis", timeout_s=60.0, function=function)
    first, waiting, last = (lab.shoot() for _ in range(3))
    for shot in (first, waiting, last):
        analyser.submit(shot.id)
    until(lambda: analyser.compiling is not None)
    (lab.store.folders.folder(last.id) / "go-on").touch()
    analyser.cancel(waiting.id)
    analyser.cancel(first.id)
    ended = outcomes.wait(3)
    assert [shot.state for shot in ended] == ["refused", "refused", "analysed"]
    for shot in ended[:2]:
        assert "its analysis was cancelled; its frames are kept" in shot.failure
        assert (shot.results, shot.outcome) == (0, "stored")
    analyser.cancel(first.id)
    (lab.store.folders.folder(first.id) / "go-on").touch()
    outcomes.records.clear()
    analyser.submit(first.id)
    assert [shot.state for shot in outcomes.wait(1)] == ["analysed"]
    analyser.close()


def test_seconds_of_a_wait_count_from_the_queue_and_a_cancelled_one_is_known_as_such(
    lab: Laboratory, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    monkeypatch.syspath_prepend(request.path.parent)
    now_s = [1000.0]
    clock = SimpleNamespace(monotonic=lambda: now_s[0])
    monkeypatch.setattr("rigctl.measuring.analysing.time", clock)
    outcomes, function = Outcomes(lab.store), "stand_in_analysis:compiles_first"
    analyser = Analyser(lab.store, workers=1, method="thesis", timeout_s=60.0, function=function)
    first, waiting = lab.shoot(), lab.shoot()
    assert analyser.awaited(first.id) is None
    analyser.submit(first.id)
    now_s[0] = 1007.0
    analyser.submit(waiting.id)
    now_s[0] = 1010.0
    assert analyser.awaited(first.id) == Awaited(10.0, is_cancelled=False)
    analyser.cancel(waiting.id)
    assert analyser.awaited(waiting.id) == Awaited(3.0, is_cancelled=True)
    (lab.store.folders.folder(first.id) / "go-on").touch()
    assert [shot.state for shot in outcomes.wait(2)] == ["analysed", "refused"]
    until(lambda: analyser.awaited(waiting.id) is None)
    analyser.close()


def test_a_shot_under_way_and_queued_again_is_not_analysed_after_its_cancel(
    lab: Laboratory,
    monkeypatch: pytest.MonkeyPatch,
    request: pytest.FixtureRequest,
    caplog: pytest.LogCaptureFixture,
) -> None:
    monkeypatch.syspath_prepend(request.path.parent)
    outcomes, function = Outcomes(lab.store), "stand_in_analysis:compiles_first"
    analyser = Analyser(lab.store, workers=1, method="thesis", timeout_s=60.0, function=function)
    shot, last = lab.shoot(), lab.shoot()
    for each in (shot, shot, shot, last):
        analyser.submit(each.id)
    until(lambda: analyser.compiling is not None)
    with caplog.at_level(logging.INFO, "rigctl.measuring.analysing"):
        analyser.cancel(shot.id)
        for each in (shot, last):
            (lab.store.folders.folder(each.id) / "go-on").touch()
        ended, after = outcomes.wait(2)
        analyser.close()
    assert (ended.state, ended.results, after.state) == ("refused", 0, "analysed")
    assert lab.store.shot(shot.id).results == 0
    of_it = [record for record in caplog.records if shot.id in record.getMessage()]
    assert [(one.levelname, one.exc_info) for one in of_it] == [("INFO", None)] * 3


def test_an_order_that_could_not_begin_is_not_what_a_later_cancel_ends(
    lab: Laboratory, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    monkeypatch.syspath_prepend(request.path.parent)
    begin, refused = Keeper.begin, list[str]()

    def fail_at_first(keeper: Keeper, shot: str) -> ShotRecord | None:
        if not refused:
            refused.append(shot)
            raise StoreError("it is being analysed already", shot=shot)
        return begin(keeper, shot)

    monkeypatch.setattr(Keeper, "begin", fail_at_first)
    outcomes, function = Outcomes(lab.store), "stand_in_analysis:measured"
    analyser = Analyser(lab.store, workers=1, method="thesis", timeout_s=60.0, function=function)
    shot, behind = lab.shoot(), lab.shoot()
    for each in (shot, behind):
        analyser.submit(each.id)
    outcomes.wait(1)
    assert refused == [shot.id]
    analyser.cancel(shot.id)
    analyser.submit(shot.id)
    assert [each.state for each in outcomes.wait(2)] == ["analysed", "analysed"]
    analyser.close()


def test_a_process_killed_after_its_result_came_is_not_given_the_next_shot(
    lab: Laboratory, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    monkeypatch.syspath_prepend(request.path.parent)
    process = AnalysisProcess("stand_in_analysis:measured")

    def cancelled_late(*given: Any, **named: Any) -> str:
        result = attending.attend(*given, **named)
        if not late:
            late.append(result)
            process.cancel()
        return result

    late = list[str]()
    monkeypatch.setattr("rigctl.measuring.analysing.attend", cancelled_late)
    # The system takes a while to clear a killed process up: until then it looks alive.
    monkeypatch.setattr(WorkerProcess, "alive", True)
    folder = lab.store.folders.folder(lab.shoot().id)
    assert process.analyse(folder, "thesis", 60.0)["status"] == "measured"
    process.expect()
    assert process.analyse(folder, "thesis", 60.0)["status"] == "measured"
    process.end()


def test_a_worker_that_cannot_be_started_costs_its_shot_alone_and_closing_still_works(
    lab: Laboratory, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    monkeypatch.syspath_prepend(request.path.parent)
    attempts: list[object] = []
    start = subprocess.Popen

    def fail_at_first(*given: Any, **named: Any) -> subprocess.Popen[bytes]:
        attempts.append(given)
        if len(attempts) == 1:
            raise OSError(11, "Resource temporarily unavailable")
        return start(*given, **named)

    monkeypatch.setattr(subprocess, "Popen", fail_at_first)
    outcomes, function = Outcomes(lab.store), "stand_in_analysis:measured"
    analyser = Analyser(lab.store, workers=1, method="thesis", timeout_s=60.0, function=function)
    analyser.submit(lab.shoot().id)
    outcomes.wait(1)
    analyser.submit(lab.shoot().id)
    failed, analysed_after = outcomes.wait(2)
    analyser.close()
    assert (failed.state, failed.failure_code) == ("refused", "analysis-failed")
    assert "could not be started: [Errno 11]" in failed.failure
    assert analysed_after.state == "analysed"


def test_an_analyser_whose_worker_never_started_closes_at_once(
    lab: Laboratory, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_given: object, **_named: object) -> None:
        raise OSError(12, "Cannot allocate memory")

    monkeypatch.setattr(subprocess, "Popen", fail)
    outcomes = Outcomes(lab.store)
    analyser = Analyser(lab.store, workers=1, method="thesis", timeout_s=60.0)
    analyser.submit(lab.shoot().id)
    assert [shot.state for shot in outcomes.wait(1)] == ["refused"]
    analyser.close()
    assert not [thread for thread in threading.enumerate() if thread.name == "analysis"]


def test_how_far_the_machine_code_is_that_a_shot_waits_for_is_told_until_it_has_it(
    lab: Laboratory, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(request.path.parent)
    outcomes, function = Outcomes(lab.store), "stand_in_analysis:compiles_first"
    analyser = Analyser(lab.store, workers=1, method="thesis", timeout_s=60.0, function=function)
    assert analyser.compiling is None
    shot = lab.shoot()
    analyser.submit(shot.id)
    until(lambda: analyser.compiling is not None)
    far = analyser.compiling
    assert far is not None
    assert (far.words, far.share) == ("3 of about 60 functions", 0.05)
    assert 0.0 < far.taken_s < BOUND_S
    (lab.store.folders.folder(shot.id) / "go-on").touch()
    assert outcomes.wait(1)[0].state == "analysed"
    assert analyser.compiling is None
    analyser.close()


def test_several_workers_share_the_shots(analysed: Callable[..., list[ShotRecord]]) -> None:
    assert [s.state for s in analysed("measured", shots=4, workers=2)] == ["analysed"] * 4


def test_closing_leaves_a_shot_under_way_to_the_next_start(
    lab: Laboratory, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(request.path.parent)
    under_way = threading.Event()
    lab.store.listeners.add(lambda shot: shot.state == "analysing" and under_way.set())
    analyser = Analyser(
        lab.store,
        workers=1,
        method="thesis",
        timeout_s=60.0,
        function="stand_in_analysis:never_ends",
    )
    shot = lab.shoot()
    analyser.submit(shot.id)
    assert under_way.wait(BOUND_S)
    analyser.close()
    lab.to_analyse.clear()
    lab.restart()
    assert lab.to_analyse == [shot.id]


def test_the_manifest_alone_describes_the_setup(lab: Laboratory) -> None:
    setup = manifest_setup(lab.store.folders.manifest(lab.shoot().id))
    assert (setup.camera.frame_rate_hz, setup.camera.height_px) == (1000.0, 192)
    assert setup.camera.front_view_rows == (88, 192)
    assert setup.camera.top_origin_px == (46.0, 120.0)
    assert [sphere.diameter_m for sphere in setup.spheres] == [0.0254, 0.0254]
    assert setup.environment.gravity_m_per_s2 == 9.80665


def test_frames_that_cannot_be_measured_are_refused_with_step_and_reason(lab: Laboratory) -> None:
    shot = lab.shoot()
    result = analyse_stored_shot(lab.store.folders.folder(shot.id), "thesis")
    assert (result["status"], result["step"], result["shot"]) == ("refused", "frames", shot.id)
