"""Whatever is asked of sweeps in whatever order: no step flies twice, and none is forgotten."""

from __future__ import annotations

import tempfile
from collections import Counter
from contextlib import suppress
from pathlib import Path

from bench import Bench, plan
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from rigctl.errors import DeviceAnswerError, FireOutcomeUnknownError, FramesError, RigError
from rigctl.store import SweepRecord
from rigctl.sweeps.plan import Rules

FAULTS = {
    "no frames": ("capture", "collect", FramesError("no frames came")),
    "trigger refuses": ("trigger", "fire", DeviceAnswerError("no power")),
    "lost answer": ("trigger", "fire", FireOutcomeUnknownError("no answer")),
    "no cut-off": ("cut_off", "check", DeviceAnswerError("no answer")),
}
WISHES = st.sampled_from(["pause", "abort", "estop", "arm", "nothing"])
FLEW = {"stored", "lost", "unknown"}


class OperatorsOfSweeps(RuleBasedStateMachine):
    """People start, steer and resume sweeps, break things, and end the daemon."""

    def __init__(self) -> None:
        super().__init__()
        self.folder = tempfile.TemporaryDirectory()
        self.bench = Bench(Path(self.folder.name) / "data")
        self.keys = 0

    def sweeps(self) -> list[SweepRecord]:
        return self.bench.lab.store.sweeps.sweeps()

    def after(self, fires: int, wish: str) -> None:
        """Let somebody interfere just as so many more fire commands have left."""
        bench, sweep = self.bench, self.sweeps

        def interfere() -> None:
            with suppress(RigError):
                if wish == "estop":
                    bench.lab.rig.estop("berta", "smoke")
                elif wish == "arm":
                    bench.lab.arm()
                elif wish != "nothing":
                    getattr(bench.runner, wish)(sweep()[0].id, "anna")

        bench.at_fire(bench.fires + fires, interfere)

    @rule(fires=st.integers(1, 3), wish=WISHES)
    def start(self, fires: int, wish: str) -> None:
        self.keys += 1
        self.after(fires, wish)
        with suppress(RigError):
            self.bench.run(plan([1.0, 2.0, 3.0], Rules(most_failed=2)), f"key {self.keys}")

    @precondition(lambda self: self.sweeps())
    @rule(data=st.data(), fires=st.integers(1, 3), wish=WISHES)
    def resume(self, data: st.DataObject, fires: int, wish: str) -> None:
        sweep = data.draw(st.sampled_from(self.sweeps()))
        self.after(fires, wish)
        with suppress(RigError):
            self.bench.resume(sweep.id)

    @precondition(lambda self: self.sweeps())
    @rule(data=st.data())
    def abort(self, data: st.DataObject) -> None:
        with suppress(RigError):
            self.bench.runner.abort(data.draw(st.sampled_from(self.sweeps())).id, "anna")

    @rule()
    def release(self) -> None:
        with suppress(RigError):
            self.bench.lab.rig.release("berta", "looked at the tubes")

    @rule(fault=st.sampled_from(sorted(FAULTS)))
    def break_something(self, fault: str) -> None:
        role, call, error = FAULTS[fault]
        getattr(self.bench.lab, role).errors[call] = error

    @rule()
    def repair(self) -> None:
        for part in (self.bench.lab.trigger, self.bench.lab.capture, self.bench.lab.cut_off):
            part.errors.clear()

    @rule()
    def end_the_daemon(self) -> None:
        self.bench.start_again()

    @invariant()
    def no_step_flies_twice(self) -> None:
        store = self.bench.lab.store
        flew: Counter[str] = Counter()
        for shot in store.shots(limit=500):
            if shot.fired != "no":
                flew[str(shot.note)] += 1
        assert all(times == 1 for times in flew.values())
        expected = {
            f"sweep {sweep.id}, step {step.number}"
            for sweep in self.sweeps()
            for step in self.bench.steps(sweep.id)
            if step.state in FLEW
        }
        assert set(flew) == expected

    @invariant()
    def no_step_is_left_open_and_nothing_armed_by_a_sweep(self) -> None:
        for sweep in self.sweeps():
            assert sweep.state != "running"
            assert all(step.state != "taken" for step in self.bench.steps(sweep.id))
        assert self.bench.lab.trigger.armed is None

    def teardown(self) -> None:
        self.bench.close()
        self.folder.cleanup()


TestOperatorsOfSweeps = OperatorsOfSweeps.TestCase
TestOperatorsOfSweeps.settings = settings(
    max_examples=15, stateful_step_count=12, deadline=None, derandomize=True
)
