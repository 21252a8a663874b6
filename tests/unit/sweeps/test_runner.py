"""A sweep fires each step once, stops when it must, and goes on where it stopped."""

from __future__ import annotations

import sqlite3
import threading
from pathlib import Path

import pytest
from bench import BOUND_S, Bench, paused, plan, settings
from rig_fakes import Blocked, in_thread

from rigctl.errors import (
    DeviceAnswerError,
    FireOutcomeUnknownError,
    FramesError,
    KeyReusedError,
    NotFoundError,
    RecordingNotConfirmedError,
    RefusedError,
    SettingsError,
)
from rigctl.store import StepState, SweepState
from rigctl.sweeps.orders import Wish
from rigctl.sweeps.plan import Plan, Rules, Until
from rigctl.sweeps.runner import SweepRunner

RESTED = "aborted by berta; slide (stand-in): stopped; regulator (stand-in): set to 0 kPa"


def test_every_step_is_fired_once_in_its_order(bench: Bench) -> None:
    done = bench.run(plan([3.0, 1.0, 2.0]))
    assert done.record.state is SweepState.COMPLETED
    assert done.record.counts == {StepState.STORED: 3}
    shots = bench.lab.store.shots()
    assert [shot.settings.offset_mm for shot in shots] == [3.0, 1.0, 2.0]
    assert [step.shot for step in bench.steps(done.record.id)] == [shot.id for shot in shots]
    assert {(shot.campaign, shot.outcome) for shot in shots} == {("nylon", "stored")}
    assert bench.lab.trigger.fired == [1, 2, 3]
    assert bench.lab.state == "idle"


@pytest.mark.parametrize(
    ("wanted", "words"),
    [
        (plan([]), "no step"),
        (plan([1.0, 25.0]), r"step 2, offset_mm.*found 25 mm, allowed 0 to 24 mm"),
        (Plan((settings(1.0, 130.0),), Rules(), "{}"), r"step 1, pressure_a_kpa.*5 to 120 kPa"),
        (plan(rules=Rules(settle_s=30.0)), r"settle_s.*found 30 s, allowed less than 30 s"),
    ],
)
def test_a_sweep_that_would_leave_the_limits_is_refused_whole(
    bench: Bench, wanted: Plan, words: str
) -> None:
    with pytest.raises(SettingsError, match=words):
        bench.start(wanted)
    assert bench.lab.store.sweeps.sweeps() == []
    assert bench.fires == 0


def test_the_same_key_gives_the_same_sweep_and_fires_nothing_more(bench: Bench) -> None:
    done = bench.run()
    assert bench.start() == done.record.id
    bench.wait(done.record.id)
    with pytest.raises(KeyReusedError):
        bench.start(body="another body")
    assert bench.fires == 3


def test_a_pause_takes_effect_before_the_next_fire_and_a_resume_goes_on_there(
    bench: Bench,
) -> None:
    bench.at_fire(2, lambda: bench.runner.pause("20260131-s0001", "anna"))
    status = bench.run(plan([1.0, 2.0, 3.0, 4.0]))
    assert paused(status) == "paused by anna"
    assert bench.states(status.record.id) == ["stored", "stored", "waiting", "waiting"]
    done = bench.resume(status.record.id)
    assert done.record.state is SweepState.COMPLETED
    assert bench.lab.trigger.fired == [1, 2, 3, 4]


def test_a_pause_is_shown_as_asked_until_the_shot_under_way_has_ended(bench: Bench) -> None:
    seen: list[tuple[str, object]] = []

    def ask() -> None:
        status = bench.runner.pause("20260131-s0001", "anna")
        seen.append((status.record.state, status.asked))

    bench.at_fire(1, ask)
    bench.run()
    assert seen == [(SweepState.RUNNING, Wish.PAUSE)]


def test_a_pause_while_the_rig_settles_leaves_the_step_waiting_and_nothing_armed(
    bench: Bench,
) -> None:
    bench.on_idle = lambda: bench.runner.pause("20260131-s0001", "anna") and None
    status = bench.run(plan(rules=Rules(settle_s=2.0)))
    assert paused(status)
    assert bench.idled == [2.0]
    assert bench.states(status.record.id) == ["waiting"] * 3
    assert (bench.fires, bench.lab.state, bench.lab.trigger.armed) == (0, "idle", None)


def test_a_resume_waits_for_the_pause_that_was_asked_for(bench: Bench) -> None:
    blocked = Blocked(bench.lab.trigger, "fire")
    sweep = bench.start()
    assert blocked.reached.wait(BOUND_S)
    bench.runner.pause(sweep, "anna")
    resumed = in_thread(lambda: bench.runner.resume(sweep, "anna") and None)
    del bench.lab.trigger.hooks["fire"]
    blocked.go_on.set()
    resumed.join(BOUND_S)
    assert bench.wait(sweep).record.counts == {StepState.STORED: 3}
    assert bench.fires == 3


def test_an_abort_ends_the_shot_under_way_skips_the_rest_and_leaves_nothing_armed(
    bench: Bench,
) -> None:
    bench.at_fire(1, lambda: bench.runner.abort("20260131-s0001", "berta"))
    status = bench.run()
    assert (status.record.state, status.record.reason) == (SweepState.ABORTED, RESTED)
    assert bench.states(status.record.id) == ["stored", "skipped", "skipped"]
    assert (bench.lab.state, bench.lab.trigger.armed) == ("idle", None)
    again = bench.runner.abort(status.record.id, "berta")
    assert again.record == status.record
    with pytest.raises(RefusedError, match="the sweep is aborted"):
        bench.runner.resume(status.record.id, "anna")


def test_a_paused_sweep_can_be_aborted(bench: Bench) -> None:
    bench.at_fire(1, lambda: bench.runner.pause("20260131-s0001", "anna"))
    status = bench.run()
    assert "regulator.vent" not in bench.lab.regulator.log
    ended = bench.runner.abort(status.record.id, "berta")
    assert ended.record.reason == RESTED
    assert ended.record.counts == {StepState.STORED: 1, StepState.SKIPPED: 2}


def test_an_abort_leaves_the_rig_to_whoever_has_armed_it(bench: Bench) -> None:
    bench.at_fire(1, lambda: bench.runner.pause("20260131-s0001", "anna"))
    status = bench.run()
    bench.lab.arm()
    ended = bench.runner.abort(status.record.id, "berta")
    assert (ended.record.reason, bench.lab.state) == ("aborted by berta", "armed")
    assert "regulator.vent" not in bench.lab.regulator.log


def test_a_second_sweep_is_refused_while_one_runs(bench: Bench) -> None:
    refused: list[str] = []

    def ask() -> None:
        for act in (lambda: bench.start(key="other"), lambda: bench.resume("20260131-s0001")):
            with pytest.raises(RefusedError, match="a sweep runs") as error:
                act()
            refused.append(error.value.code)

    bench.at_fire(1, ask)
    bench.run()
    assert refused == ["refused", "refused"]
    assert len(bench.lab.store.sweeps.sweeps()) == 1


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


def test_rests_and_settling_are_as_the_rules_say(bench: Bench) -> None:
    bench.run(plan([1.0, 2.0], Rules(settle_s=2.0, pause_s=5.0)))
    assert bench.idled == [2.0, 5.0, 2.0, 5.0]


def test_time_left_is_the_mean_cycle_times_the_steps_that_wait(bench: Bench) -> None:
    left: list[float | None] = []
    bench.on_idle = lambda: left.append(bench.runner.status("20260131-s0001").left_s)
    bench.run(plan([1.0, 2.0, 3.0], Rules(pause_s=100.0)))
    assert left[0] is not None
    assert left[0] < 10.0
    assert left[1] is not None
    assert left[1] == pytest.approx(52.0, rel=0.05)
    assert left[2] == 0.0


def test_time_left_is_counted_whatever_the_hosts_clock_is_set_to(bench: Bench) -> None:
    left: list[float | None] = []
    bench.on_idle = lambda: left.append(bench.runner.status("20260131-s0001").left_s)
    bench.at_fire(2, lambda: setattr(bench.lab.time, "step_s", 7200.0))
    bench.run(plan([1.0, 2.0, 3.0], Rules(pause_s=100.0)))
    assert left[1] == pytest.approx(52.0, rel=0.05)


def test_listeners_hear_of_every_step_and_of_the_end(bench: Bench) -> None:
    heard: list[tuple[str, int, int | None]] = []
    bench.runner.listeners.add(
        lambda status: heard.append(
            (
                status.record.state,
                status.record.counts.get(StepState.STORED, 0),
                None if status.step is None else status.step.number,
            )
        )
    )
    bench.run(plan([1.0, 2.0]))
    assert heard == [
        ("running", 0, None),
        ("running", 0, 1),
        ("running", 1, None),
        ("running", 1, 2),
        ("running", 2, None),
        ("completed", 2, None),
    ]


def test_the_end_of_the_daemon_pauses_the_sweep_after_its_shot(bench: Bench) -> None:
    sweep = bench.start(plan([1.0] * 200))
    bench.runner.close()
    status = bench.runner.status(sweep)
    assert "the daemon ended" in paused(status)
    assert StepState.TAKEN not in status.record.counts
    with pytest.raises(RefusedError, match="the daemon ends"):
        bench.runner.resume(sweep, "anna")


def test_a_sweep_that_is_not_there_is_not_found(bench: Bench) -> None:
    for act in (bench.runner.pause, bench.runner.resume, bench.runner.abort):
        with pytest.raises(NotFoundError, match="no such sweep"):
            act("20260131-s0009", "anna")


def test_a_sweep_that_has_ended_cannot_be_paused(bench: Bench) -> None:
    done = bench.run()
    with pytest.raises(RefusedError, match="the sweep is completed"):
        bench.runner.pause(done.record.id, "anna")


def test_a_coefficient_that_is_known_well_enough_ends_the_sweep_early(bench: Bench) -> None:
    def measure_what_is_stored() -> None:
        for shot in bench.lab.store.shots():
            if shot.state == "stored":
                bench.measure(shot.id, 0.74, 0.01)

    bench.on_idle = measure_what_is_stored
    rules = Rules(pause_s=1.0, until=Until("e", 0.005))
    status = bench.run(plan([1.0] * 10, rules))
    assert status.record.state is SweepState.COMPLETED
    assert "e is 0.74 with a standard error of 0.005" in status.record.reason
    assert status.record.counts == {StepState.STORED: 4, StepState.SKIPPED: 6}
