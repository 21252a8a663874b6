"""Whatever is asked in whatever order: one fire for each accepted key, none without power."""

from __future__ import annotations

import tempfile
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule
from rig_fakes import SETTINGS, Laboratory

from rigctl.errors import (
    DeviceAnswerError,
    FireOutcomeUnknownError,
    FramesError,
    RecordingNotConfirmedError,
    RigError,
)
from rigctl.rig.states import LATCHED, TRANSITIONS, RigState

FAULTS = {
    "no recording": ("capture", "start", RecordingNotConfirmedError("no tape")),
    "no frames": ("capture", "collect", FramesError("no frames came")),
    "trigger refuses": ("trigger", "fire", DeviceAnswerError("no power")),
    "lost answer": ("trigger", "fire", FireOutcomeUnknownError("no answer")),
    "unsafe": ("trigger", "make_safe", DeviceAnswerError("no answer")),
}
KEYS = st.sampled_from(["k1", "k2", "k3", "k4", "k5", "k6"])
REACHED_FIRE = {"stored", "misfire", "unknown_outcome"}


class OperatorsOfOneRig(RuleBasedStateMachine):
    """People arm, fire, stop, release, break things and kill the daemon."""

    def __init__(self) -> None:
        super().__init__()
        self.folder = tempfile.TemporaryDirectory()
        self.lab = Laboratory(Path(self.folder.name) / "data")
        self.tokens = ["never issued"]
        self.unpowered_fires = 0
        self.lab.trigger.hooks["fire"] = self.note_power

    def note_power(self) -> None:
        self.unpowered_fires += not self.lab.cut_off.power

    @rule(offset=st.sampled_from([3.0, 6.0, 30.0]))
    def arm(self, offset: float) -> None:
        changed = SETTINGS.model_copy(update={"offset_mm": offset})
        with suppress(RigError):
            self.tokens.append(self.lab.rig.arm(changed, "anna").token)

    @rule(key=KEYS, body=st.sampled_from(["a", "b"]), data=st.data())
    def fire(self, key: str, body: str, data: st.DataObject) -> None:
        token = data.draw(st.sampled_from(self.tokens))
        with suppress(RigError):
            self.lab.rig.fire(token, key, body, actor="anna")

    @rule(key=KEYS)
    def fire_with_the_newest_token(self, key: str) -> None:
        with suppress(RigError):
            self.lab.rig.fire(self.tokens[-1], key, "a", actor="anna")

    @rule(seconds=st.sampled_from([0.01, 1.0, 31.0]))
    def wait(self, seconds: float) -> None:
        self.lab.time.pass_time(seconds)

    @rule()
    def stop(self) -> None:
        self.lab.rig.estop("berta", "smoke")

    @rule(reason=st.sampled_from(["", "looked at it"]))
    def release(self, reason: str) -> None:
        before = self.lab.rig.status().state
        with suppress(RigError):
            self.lab.rig.release("berta", reason)
            assert reason
            assert before in LATCHED

    @rule(fault=st.sampled_from(sorted(FAULTS)))
    def break_something(self, fault: str) -> None:
        role, call, error = FAULTS[fault]
        getattr(self.lab, role).errors[call] = error

    @precondition(lambda self: self.lab.trigger.errors or self.lab.capture.errors)
    @rule()
    def repair(self) -> None:
        self.lab.trigger.errors.clear()
        self.lab.capture.errors.clear()

    @rule()
    def kill_the_daemon(self) -> None:
        self.lab.restart()

    @invariant()
    def as_many_fires_as_shots_that_reached_the_fire_command(self) -> None:
        shots = self.lab.store.shots(limit=1000)
        sent = [
            shot.number
            for shot in shots
            if shot.outcome in REACHED_FIRE or (shot.outcome == "aborted" and shot.fired == "yes")
        ]
        assert self.lab.trigger.fired == sent
        assert len(shots) <= 6

    @invariant()
    def nothing_is_fired_without_power_or_left_open(self) -> None:
        assert self.unpowered_fires == 0
        assert all(shot.outcome is not None for shot in self.lab.store.shots(limit=1000))

    @invariant()
    def the_trigger_is_never_left_armed(self) -> None:
        assert self.lab.trigger.armed is None or "make_safe" in self.lab.trigger.errors

    @invariant()
    def a_person_ended_every_latched_state(self) -> None:
        for entry in self.lab.store.journal.entries(limit=1000):
            before, after = RigState(entry.before), RigState(entry.after)
            assert after in TRANSITIONS[before] or entry.actor == "rig"
            if before in LATCHED and after is RigState.IDLE:
                assert entry.actor == "berta"

    def teardown(self) -> None:
        self.lab.store.journal.verify()
        self.lab.close()
        self.folder.cleanup()


TestOperatorsOfOneRig = OperatorsOfOneRig.TestCase
TestOperatorsOfOneRig.settings = settings(
    max_examples=15, stateful_step_count=20, deadline=None, derandomize=True
)


class OperatorsForLong(OperatorsOfOneRig):
    """The same people on many more days."""


TestOperatorsForLong = pytest.mark.long(OperatorsForLong.TestCase)
TestOperatorsForLong.settings = settings(
    max_examples=80, stateful_step_count=20, deadline=None, derandomize=True
)
