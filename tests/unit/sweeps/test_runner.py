"""A sweep fires each step once, stops when it must, and goes on where it stopped."""

from __future__ import annotations

import pytest
from bench import BOUND_S, Bench, paused, plan, settings
from rig_fakes import Blocked, in_thread

from rigctl.errors import (
    KeyReusedError,
    NotFoundError,
    RefusedError,
    SettingsError,
)
from rigctl.store import StepState, SweepState
from rigctl.sweeps.orders import Wish
from rigctl.sweeps.plan import Plan, Rules, Until

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
