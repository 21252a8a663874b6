"""The trigger box's watch: heartbeats reach the box; a box that misses them stops the rig."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from queue import SimpleQueue

import pytest
from rig_fakes import BOUND_S, Laboratory, until

from rigctl.devices.serial_port import SerialPort
from rigctl.devices.trigger_box import TriggerBox
from rigctl.errors import DeviceError, DeviceSilentError
from rigctl.rig.stopping.box_watch import BoxWatch
from rigctl.rig.stopping.dead_man import SILENT_S
from simulators.wire.faults import SerialDevice, SerialFaults
from simulators.wire.framing import Lines
from simulators.wire.pty_port import PtyPort
from simulators.wire.trigger_box import Pulses
from simulators.wire.trigger_box import TriggerBox as SimulatedBox


class Bench:
    """The driver over a wire to a simulated box, whose clock a test moves."""

    def __init__(self, folder: Path, version: int) -> None:
        self.now_s = 0.0
        self.box = SimulatedBox(lambda: self.now_s, lambda _: None, version=version)
        self.box.power(True)
        self.faults = SerialFaults()
        device = SerialDevice(Lines(b"\n"), self.box.answer, self.faults)
        self._far = PtyPort(device.receive, folder / "box")
        port = SerialPort(self._far.path, part="trigger", baud=115200, answer_timeout_s=2.0)
        self.driver = TriggerBox(port, pulse_us=20000)
        self.told: SimpleQueue[str] = SimpleQueue()
        self.watch = BoxWatch(self.driver, lambda: self.now_s)

    def close(self) -> None:
        self.watch.end()
        self.driver.close()
        self._far.close()


@pytest.fixture
def benches(tmp_path: Path) -> Iterator[Callable[..., Bench]]:
    built: list[Bench] = []

    def build(version: int = 2) -> Bench:
        built.append(Bench(tmp_path, version))
        return built[-1]

    yield build
    for bench in built:
        bench.close()


def test_heartbeats_keep_the_box_watching_as_long_as_the_daemon_answers(
    benches: Callable[..., Bench],
) -> None:
    bench = benches()
    asked: list[None] = []

    def alive() -> bool:
        asked.append(None)
        return True

    bench.watch.start(alive, bench.told.put)
    # One answer that is lost on the way does no harm.
    bench.faults.set("garbage", times=1)
    for _ in range(4):
        bench.now_s += SILENT_S / 2
        so_far = len(asked)
        # Questions go before heartbeats: the third comes after a heartbeat of the present time.
        until(lambda so_far=so_far: len(asked) >= so_far + 3)
    assert bench.box.late_since_s is None
    assert bench.watch.watches
    assert bench.told.empty()


def test_a_daemon_that_no_longer_answers_is_followed_by_a_safe_box(
    benches: Callable[..., Bench],
) -> None:
    bench = benches()
    answers = threading.Event()
    bench.watch.start(answers.is_set, bench.told.put)
    bench.driver.arm(1, 0.0)
    bench.now_s = SILENT_S
    assert not bench.box.is_armed
    assert bench.box.late_since_s == pytest.approx(SILENT_S)
    answers.set()
    assert "no heartbeat came in time" in bench.told.get(timeout=BOUND_S)
    assert not bench.watch.watches


def test_a_box_that_no_heartbeat_reaches_is_told_of_once_it_must_be_safe(
    benches: Callable[..., Bench],
) -> None:
    bench = benches()
    bench.watch.start(lambda: True, bench.told.put)
    bench.faults.set("disconnect")
    bench.now_s = SILENT_S
    assert "no heartbeat reached it" in bench.told.get(timeout=BOUND_S)


def test_after_an_orderly_end_the_box_watches_no_more_and_nobody_is_told(
    benches: Callable[..., Bench],
) -> None:
    bench = benches()
    bench.watch.start(lambda: True, bench.told.put)
    bench.watch.end()
    bench.now_s = 10 * SILENT_S
    assert bench.box.late_since_s is None
    assert bench.told.empty()


def test_a_box_of_before_the_heartbeat_is_named_in_the_log_and_left_as_it_is(
    benches: Callable[..., Bench], caplog: pytest.LogCaptureFixture
) -> None:
    bench = benches(version=1)
    bench.watch.start(lambda: True, bench.told.put)
    assert not bench.watch.watches
    assert "without heartbeat" in caplog.text
    bench.driver.arm(1, 0.0)
    bench.driver.fire(1)


def test_power_is_not_given_where_the_box_does_not_answer(
    tmp_path: Path, benches: Callable[..., Bench]
) -> None:
    bench, lab = benches(), Laboratory(tmp_path / "data")
    lab.rig._stop._watches = (bench.watch,)
    bench.faults.set("wrong-checksum", command="WATCH")
    lab.rig.estop("berta", "smoke")
    with pytest.raises(DeviceError, match="checksum"):
        lab.rig.release("berta", "only steam")
    assert (lab.state, lab.cut_off.power) == ("estop", False)
    lab.close()


DAEMON = """
import sys
from rigctl.devices.serial_port import SerialPort
from rigctl.devices.trigger_box import TriggerBox
from rigctl.errors import DeviceError
from rigctl.rig.stopping.box_watch import BoxWatch

port = SerialPort(sys.argv[1], part="trigger", baud=115200, answer_timeout_s=2.0)
box = TriggerBox(port, pulse_us=20000)
BoxWatch(box).start(lambda: True, lambda why: None)
box.arm(1, 0.0)
print("armed", flush=True)
sys.stdin.readline()
try:
    print("fired", box.fire(1))
except DeviceError as error:
    print("refused", error)
"""
"""What a daemon does that arms, and fires once it is told to."""


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_from_the_daemons_death_or_halt_the_box_is_safe_in_time_and_stays_so(
    tmp_path: Path, number: signal.Signals
) -> None:
    now_s = 0.0
    pulses: list[Pulses] = []
    box = SimulatedBox(lambda: now_s, pulses.append, contact_in_power=True)
    box.power(True)
    device = SerialDevice(Lines(b"\n"), box.answer, SerialFaults())
    with (
        contextlib.closing(PtyPort(device.receive, tmp_path / "box")) as far,
        subprocess.Popen(
            [sys.executable, "-c", DAEMON, far.path], stdin=-1, stdout=-1, text=True
        ) as daemon,
    ):
        assert daemon.stdout is not None
        assert daemon.stdout.readline() == "armed\n"
        assert box.is_armed
        daemon.send_signal(number)
        now_s = SILENT_S
        until(lambda: box.late_since_s is not None)
        assert box.late_since_s == pytest.approx(SILENT_S)
        assert (box.is_armed, box.is_powered) == (False, False)
        daemon.send_signal(signal.SIGCONT)
        said, _ = daemon.communicate("go on\n", timeout=BOUND_S)
        assert "fired" not in said
    assert pulses == []


class Deaf:
    """A box that hears one heartbeat in two, or says that it was late."""

    def __init__(self) -> None:
        self.late, self.watched = False, 0

    def watch(self, within_s: float) -> bool:
        self.late, self.watched = False, self.watched + 1
        return True

    def beat(self) -> bool:
        if self.late:
            return False
        raise DeviceSilentError("no answer")

    def end_watch(self) -> None: ...


def test_a_safe_box_stops_the_rig_and_a_release_has_it_watch_again(tmp_path: Path) -> None:
    lab, box = Laboratory(tmp_path / "data", threads=True), Deaf()
    lab.rig._stop._watches = (BoxWatch(box, lambda: 0.0),)
    lab.rig.estop("berta", "smoke")
    lab.rig.release("berta", "only steam")
    box.late = True
    until(lambda: lab.state == "estop")
    assert lab.cut_off.power is False
    lab.rig.release("berta", "the host was busy")
    assert (lab.state, box.watched) == ("idle", 2)
    lab.close()
