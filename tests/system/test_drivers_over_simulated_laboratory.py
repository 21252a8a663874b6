"""The real drivers over the simulated laboratory: one shot, and every fault by its name."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from rigctl.cameras.build import build_capture
from rigctl.cameras.capture import Capture
from rigctl.config import Configuration, default_path, load
from rigctl.devices.build import build_actuators
from rigctl.devices.roles import (
    Actuator,
    Actuators,
    FireOutcome,
    OutcomeQuery,
    PowerQuery,
    Regulator,
    Slide,
)
from rigctl.errors import (
    DeviceAbsentError,
    DeviceAnswerError,
    DeviceSilentError,
    FireOutcomeUnknownError,
    FramesError,
    RecordingNotConfirmedError,
    RigError,
)
from simulators.laboratory import Laboratory
from simulators.options import read_options
from tests.simulated import LaboratoryClock, patient


class Bench:
    """The simulated laboratory with the drivers of its configuration, powered."""

    def __init__(self, folder: Path, configuration: Configuration) -> None:
        self.configuration = configuration
        self.clock = LaboratoryClock()
        self.laboratory = Laboratory(folder, read_options({"seed": 3}), None, self.clock)
        self.actuators: Actuators = build_actuators(self.configuration, self.laboratory)
        self.capture: Capture = build_capture(self.configuration.camera, self.laboratory)
        self.actuators.cut_off.restore()
        self.wait_until(self.is_powered)

    @property
    def regulator(self) -> Regulator:
        assert self.actuators.regulator is not None
        return self.actuators.regulator

    @property
    def slide(self) -> Slide:
        assert self.actuators.slide is not None
        return self.actuators.slide

    def part(self, role: str) -> Actuator:
        return {
            "trigger": self.actuators.trigger,
            "regulator": self.regulator,
            "slide": self.slide,
            "cut-off": self.actuators.cut_off,
        }[role]

    def is_powered(self) -> bool:
        assert isinstance(self.actuators.trigger, PowerQuery)
        return self.actuators.trigger.powered()

    def wait_until(self, condition: Callable[[], bool]) -> None:
        """Ask again and again, a minute at most."""
        deadline = time.monotonic() + 60.0
        while not condition():
            assert time.monotonic() < deadline, "the condition was not reached within a minute"
            time.sleep(0.001)

    def outcome(self, sequence: int) -> FireOutcome:
        assert isinstance(self.actuators.trigger, OutcomeQuery)
        return self.actuators.trigger.outcome(sequence)

    def close(self) -> None:
        parts = (self.actuators.trigger, self.regulator, self.slide, self.actuators.cut_off)
        for part in (*parts, self.capture):
            part.close()
        self.laboratory.close()


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    made = Bench(tmp_path, load(default_path()))
    yield made
    made.close()


@pytest.fixture
def patient_bench(tmp_path: Path) -> Iterator[Bench]:
    """A bench whose answers may be as late as a busy machine makes them."""
    made = Bench(tmp_path, patient(load(default_path())))
    yield made
    made.close()


def test_one_shot_from_set_points_to_frames(patient_bench: Bench) -> None:
    bench = patient_bench
    bench.regulator.set_pressure(40.0, 35.0)
    bench.slide.move_to(6.0)
    bench.wait_until(lambda: not bench.slide.is_moving())
    bench.wait_until(lambda: abs(bench.regulator.pressure()[1].value - 35.0) < 0.5)
    assert bench.slide.position().value == pytest.approx(6.0, abs=0.001)
    bench.capture.start()
    # The spheres fly past within 0.1 s of the fire: the marker is set at the moment of the fire.
    with bench.clock.stopped():
        bench.actuators.trigger.arm(1, 0.0)
        receipt = bench.actuators.trigger.fire(1)
        bench.capture.mark()
    frames = bench.capture.collect()
    camera = bench.configuration.camera
    count = camera.frames_before_mark + camera.frames_after_mark
    # As many pictures more as the answers to the trigger took.
    assert frames.pixels.shape[0] >= count
    assert frames.pixels.shape[1:] == (camera.rows, camera.columns)
    assert frames.lost == ()
    assert receipt.device_time_us is not None
    assert bench.laboratory.fires == 1
    assert bench.outcome(1) is FireOutcome.FIRED
    # Two spheres reflect more light than the empty scene, so they must have come into view.
    brightness = frames.pixels.mean(axis=(1, 2))
    assert brightness.max() > brightness.min() + 1.0


@pytest.mark.parametrize("kind", ["no-answer", "half-answer", "garbage", "wrong-checksum"])
def test_a_fire_whose_answer_is_spoiled_fires_once_and_is_settled_by_asking(
    bench: Bench, kind: str
) -> None:
    bench.actuators.trigger.arm(1, 0.0)
    bench.laboratory.fault("trigger", kind, times=1, command="FIRE")
    with pytest.raises(FireOutcomeUnknownError):
        bench.actuators.trigger.fire(1)
    assert bench.outcome(1) is FireOutcome.FIRED
    assert bench.laboratory.fires == 1


def test_a_fire_that_was_lost_on_the_way_is_settled_as_not_fired(bench: Bench) -> None:
    bench.actuators.trigger.arm(1, 0.0)
    bench.laboratory.fault("trigger", "deaf", times=1, command="FIRE")
    with pytest.raises(FireOutcomeUnknownError):
        bench.actuators.trigger.fire(1)
    assert bench.outcome(1) is FireOutcome.NOT_FIRED
    assert bench.laboratory.fires == 0


def test_a_late_answer_to_one_shot_does_not_confirm_the_next(bench: Bench) -> None:
    trigger = bench.actuators.trigger
    trigger.arm(1, 0.0)
    bench.laboratory.fault("trigger", "late-answer", times=1, delay_s=0.7, command="FIRE")
    with pytest.raises(FireOutcomeUnknownError):
        trigger.fire(1)
    trigger.arm(2, 0.0)
    bench.laboratory.fault("trigger", "deaf", times=1, command="FIRE")
    with pytest.raises(FireOutcomeUnknownError):
        trigger.fire(2)
    assert bench.laboratory.fires == 1


def test_a_trigger_that_hangs_up_while_firing_leaves_a_doubt(bench: Bench) -> None:
    bench.actuators.trigger.arm(1, 0.0)
    bench.laboratory.fault("trigger", "disconnect", times=1, command="FIRE")
    with pytest.raises(FireOutcomeUnknownError):
        bench.actuators.trigger.fire(1)
    assert bench.outcome(1) is FireOutcome.UNKNOWN
    assert bench.laboratory.fires == 1


def test_without_power_nothing_fires_and_the_box_says_why(bench: Bench) -> None:
    bench.actuators.trigger.arm(1, 0.0)
    bench.actuators.cut_off.cut()
    bench.wait_until(lambda: not bench.is_powered())
    with pytest.raises(DeviceAnswerError, match="restore the cut-off"):
        bench.actuators.trigger.fire(1)
    assert bench.laboratory.fires == 0


@pytest.mark.parametrize(
    ("kind", "named"),
    [
        ("no-answer", DeviceSilentError),
        ("half-answer", DeviceAnswerError),
        ("garbage", DeviceAnswerError),
        ("disconnect", DeviceAbsentError),
    ],
)
@pytest.mark.parametrize("role", ["trigger", "regulator", "recorder"])
def test_each_fault_of_a_line_has_its_name_and_passes_when_it_is_cleared(
    bench: Bench, role: str, kind: str, named: type[RigError]
) -> None:
    part = bench.capture if role == "recorder" else bench.part(role)
    bench.laboratory.fault(role, kind, times=1)
    with pytest.raises(named):
        part.check()
    bench.laboratory.clear_faults()
    if role != "recorder":
        bench.part(role).reopen()
    part.check()


@pytest.mark.parametrize("role", ["trigger", "regulator", "slide", "cut-off"])
def test_an_actuator_that_was_unplugged_comes_back_when_it_is_reopened_and_not_before(
    bench: Bench, role: str
) -> None:
    part = bench.part(role)
    bench.laboratory.fault(role, "unplug")
    with pytest.raises((DeviceAbsentError, DeviceSilentError)):
        part.reopen()
    bench.laboratory.fault(role, "plug-in")
    with pytest.raises((DeviceAbsentError, DeviceSilentError)):
        part.check()
    part.reopen()
    part.check()


@pytest.mark.parametrize("role", ["trigger", "regulator", "slide", "cut-off"])
def test_a_loss_that_nobody_noticed_is_found_by_reopening(bench: Bench, role: str) -> None:
    bench.laboratory.fault(role, "unplug")
    bench.laboratory.fault(role, "plug-in")
    bench.part(role).reopen()
    bench.part(role).check()


def test_a_trigger_that_was_armed_and_came_back_fires_nothing(bench: Bench) -> None:
    trigger = bench.actuators.trigger
    trigger.arm(1, 0.0)
    bench.laboratory.fault("trigger", "unplug")
    bench.laboratory.fault("trigger", "plug-in")
    trigger.reopen()
    with pytest.raises(DeviceAnswerError, match="no fire command was sent"):
        trigger.fire(1)
    assert bench.laboratory.fires == 0


def test_a_cut_reaches_a_board_that_was_unplugged_and_is_back(bench: Bench) -> None:
    bench.laboratory.fault("cut-off", "unplug")
    with pytest.raises(DeviceAbsentError):
        bench.actuators.cut_off.cut()
    bench.laboratory.fault("cut-off", "plug-in")
    bench.actuators.cut_off.cut()
    bench.wait_until(lambda: not bench.is_powered())


def test_a_slide_is_stopped_on_its_way_and_the_regulators_are_vented(bench: Bench) -> None:
    bench.regulator.set_pressure(40.0, 35.0)
    bench.slide.move_to(20.0)
    bench.slide.stop()
    bench.wait_until(lambda: not bench.slide.is_moving())
    assert 0.0 <= bench.slide.position().value < 20.0
    bench.regulator.vent()
    bench.wait_until(lambda: max(p.value for p in bench.regulator.pressure()) < 0.1)


@pytest.mark.parametrize("kind", ["stuck", "timeout", "disconnect"])
def test_a_remote_trigger_that_fails_means_no_recording(bench: Bench, kind: str) -> None:
    bench.laboratory.fault("relay", kind)
    with pytest.raises(RigError):
        bench.capture.start()
    bench.laboratory.clear_faults()
    bench.capture.start()


def test_a_tape_that_never_starts_is_not_confirmed(bench: Bench) -> None:
    bench.laboratory.fault("recorder", "never-starts")
    with pytest.raises(RecordingNotConfirmedError):
        bench.capture.start()


@pytest.mark.parametrize(
    "kind", ["short-stack", "extra-frame", "frozen", "wrong-size", "truncated-tiff"]
)
def test_spoiled_frames_are_refused_and_the_next_shot_is_whole(bench: Bench, kind: str) -> None:
    bench.laboratory.fault("recorder", kind, times=1)
    bench.capture.start()
    bench.capture.mark()
    with pytest.raises(FramesError):
        bench.capture.collect()
    bench.capture.start()
    bench.capture.mark()
    assert bench.capture.collect().lost == ()


def test_frames_that_the_digitiser_admits_to_have_lost_stay_named(bench: Bench) -> None:
    bench.laboratory.fault("recorder", "missing-frames", times=1, frames=2)
    bench.capture.start()
    bench.capture.mark()
    frames = bench.capture.collect()
    assert len(frames.lost) == 2
    assert not set(frames.lost) & set(frames.sequence.tolist())
