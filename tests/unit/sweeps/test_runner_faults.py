"""What goes wrong while a sweep runs: it pauses, and no step is fired twice."""

from __future__ import annotations

import sqlite3
import threading
from pathlib import Path

import pytest
from bench import Bench, paused, plan

from rigctl.errors import (
    DeviceAnswerError,
    FireOutcomeUnknownError,
    FramesError,
    RecordingNotConfirmedError,
    RefusedError,
)
from rigctl.store import StepState, SweepState
from rigctl.sweeps.plan import Rules
from rigctl.sweeps.runner import SweepRunner

RESTED = None


def test_a_tripped_interlock_pauses_the_sweep_and_its_step_is_fired_after_the_repair(
    bench: Bench,
) -> None:
    bench.lab.regulator.error_kpa = 3.0
    status = bench.run()
    assert "pressure_a: 43 kPa, needed 40 ± 0.5 kPa" in paused(status)
    assert (bench.fires, bench.states(status.record.id)) == (0, ["waiting"] * 3)
    bench.lab.regulator.error_kpa = 0.0
    assert bench.resume(status.record.id).record.counts == {StepState.STORED: 3}


def test_a_full_disk_pauses_the_sweep_before_anything_fires(bench: Bench) -> None:
    bench.at_fire(1, lambda: setattr(bench.lab, "free_mb", 10.0))
    status = bench.run()
    assert "disk: 10 MB, needed at least 200 MB" in paused(status)
    assert bench.fires == 1
    bench.lab.free_mb = 1e6
    assert bench.resume(status.record.id).record.counts == {StepState.STORED: 3}


@pytest.mark.parametrize("step_s", [-30 * 3600.0, 30 * 3600.0])
def test_a_host_whose_clock_is_set_pauses_the_sweep_and_no_step_is_fired_twice(
    bench: Bench, step_s: float
) -> None:
    bench.at_fire(2, lambda: setattr(bench.lab.time, "step_s", step_s))
    status = bench.run(plan([1.0, 2.0, 3.0], Rules(pause_s=100.0)))
    assert "clock: " in paused(status)
    # The shot that was recorded meanwhile is whole: only its time of day is another.
    assert bench.states(status.record.id) == ["stored", "stored", "waiting"]
    assert bench.resume(status.record.id).record.counts == {StepState.STORED: 3}
    assert bench.fires == 3
    numbers = [shot.number for shot in bench.lab.store.catalogue.shots(limit=10)]
    assert numbers == sorted(numbers)
    assert bench.lab.store.catalogue.last().number == max(numbers)


def test_steps_that_fail_one_after_another_pause_the_sweep_and_only_unfired_ones_are_repeated(
    bench: Bench,
) -> None:
    bench.lab.trigger.errors["fire"] = DeviceAnswerError("no power")
    status = bench.run(plan([1.0, 2.0, 3.0, 4.0], Rules(most_failed=2)))
    assert "2 steps in a row came to nothing" in paused(status)
    assert bench.states(status.record.id) == ["not_fired", "not_fired", "waiting", "waiting"]
    del bench.lab.trigger.errors["fire"]
    done = bench.resume(status.record.id)
    assert done.record.counts == {StepState.STORED: 4}
    assert [step.attempt for step in bench.steps(done.record.id)] == [2, 2, 1, 1]


def test_a_good_step_between_failures_starts_the_count_anew(bench: Bench) -> None:
    def refuse() -> None:
        if bench.fires % 2:
            raise DeviceAnswerError("no power")

    bench.lab.trigger.hooks["fire"] = refuse
    status = bench.run(plan([1.0, 2.0, 3.0, 4.0], Rules(most_failed=2)))
    assert status.record.state is SweepState.COMPLETED
    assert bench.states(status.record.id) == ["not_fired", "stored", "not_fired", "stored"]


def test_spheres_that_flew_without_frames_are_lost_and_never_fired_again(bench: Bench) -> None:
    bench.lab.capture.errors["collect"] = FramesError("no frames came")
    status = bench.run(plan(rules=Rules(most_failed=1)))
    assert "no frames came" in paused(status)
    del bench.lab.capture.errors["collect"]
    bench.resume(status.record.id)
    assert bench.states(status.record.id) == ["lost", "stored", "stored"]
    assert bench.fires == 3


def test_a_camera_that_does_not_record_fires_nothing_and_the_step_waits_again(
    bench: Bench,
) -> None:
    bench.lab.capture.errors["start"] = RecordingNotConfirmedError("no tape")
    status = bench.run(plan(rules=Rules(most_failed=1)))
    assert "no tape" in paused(status)
    assert bench.fires == 0
    del bench.lab.capture.errors["start"]
    assert bench.resume(status.record.id).record.counts == {StepState.STORED: 3}


def test_an_unknown_outcome_is_never_fired_again_and_a_person_comes_first(bench: Bench) -> None:
    bench.lab.trigger.errors["fire"] = FireOutcomeUnknownError("no answer")
    status = bench.run()
    sweep = status.record.id
    assert "whether step 1 (shot 20260131-000001) fired is not known" in paused(status)
    del bench.lab.trigger.errors["fire"]
    with pytest.raises(RefusedError, match="unknown_outcome"):
        bench.runner.resume(sweep, "anna")
    bench.lab.rig.release("anna", "looked at the tubes")
    done = bench.resume(sweep)
    assert bench.states(sweep) == ["unknown", "stored", "stored"]
    assert done.record.state is SweepState.COMPLETED
    assert bench.lab.trigger.fired == [1, 2, 3]


def test_an_emergency_stop_holds_the_sweep_until_the_rig_is_released(bench: Bench) -> None:
    bench.at_fire(2, lambda: bench.lab.rig.estop("berta", "smoke"))
    status = bench.run()
    assert paused(status)
    assert bench.fires == 2
    with pytest.raises(RefusedError, match="estop: smoke"):
        bench.start(key="other")
    bench.lab.rig.release("berta", "all clear")
    bench.resume(status.record.id)
    assert bench.states(status.record.id) == ["stored", "unknown", "stored"]


def test_somebody_who_arms_the_rig_keeps_it_and_the_sweep_waits(bench: Bench) -> None:
    tokens: list[str] = []
    bench.on_idle = lambda: tokens.append(bench.lab.arm())
    status = bench.run(plan(rules=Rules(settle_s=1.0)))
    assert "step 1 was not fired" in paused(status)
    assert bench.lab.fire(tokens[0]).outcome == "stored"
    assert bench.states(status.record.id) == ["not_fired", "waiting", "waiting"]


def test_a_catalogue_that_another_program_locks_pauses_the_sweep_and_nothing_is_lost(
    bench: Bench, tmp_path: Path
) -> None:
    holder = sqlite3.connect(
        tmp_path / "data" / "catalogue.db", isolation_level=None, check_same_thread=False
    )
    bench.on_idle = lambda: bench.fires == 1 and holder.execute("BEGIN IMMEDIATE") and None
    status = bench.run(plan(rules=Rules(pause_s=1.0)))
    assert "not on disk" in paused(status)
    assert "locked" in status.record.reason
    assert bench.fires == 1
    holder.execute("ROLLBACK")
    holder.close()
    bench.on_idle = lambda: None
    bench.lab.time.pass_time(60.0)
    if bench.lab.state == "fault":
        bench.lab.rig.release("anna", "the other program has ended")
    done = bench.resume(status.record.id)
    assert done.record.counts == {StepState.STORED: 3}
    assert bench.fires == 3


def test_an_error_in_the_program_pauses_the_sweep(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    def break_down(_: str) -> None:
        raise ZeroDivisionError("a bug")

    monkeypatch.setattr(bench.lab.store.sweeps, "next_step", break_down)
    assert "ZeroDivisionError('a bug')" in paused(bench.run())


def test_a_sweep_whose_thread_cannot_be_started_is_paused_and_can_be_resumed(
    bench: Bench,
) -> None:
    def refuse(_: object) -> threading.Thread:
        raise RuntimeError("can't start new thread")

    runner = SweepRunner(
        bench.lab.rig,
        bench.lab.store,
        bench.lab.configuration,
        clock=bench.lab.time.clock(),
        spawn=refuse,
    )
    with pytest.raises(RefusedError, match="can't start new thread"):
        runner.start(plan(), "key", "body", "anna")
    assert "could not be started" in paused(bench.runner.status("20260131-s0001"))
    assert bench.resume("20260131-s0001").record.counts == {StepState.STORED: 3}
