from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import pytest
import serial

from simulators.wire.faults import Answer, SerialDevice, SerialFault, SerialFaults
from simulators.wire.framing import Lines
from simulators.wire.pty_port import PtyPort

ANSWER = b"PONG 0123456789*AF\n"
QUIET_S = 0.15
BOUND_S = 60.0


class Bench:
    """A device that answers each line with `ANSWER`, its faults, and a host's port."""

    def __init__(self, folder: Path) -> None:
        self.heard: list[bytes] = []
        self.echoes = False
        self.faults = SerialFaults()
        device = SerialDevice(Lines(b"\n"), self._answer, self.faults)
        self.port = PtyPort(device.receive, folder / "device")
        self.host = self.open()

    def _answer(self, line: bytes) -> bytes:
        self.heard.append(line)
        return line + b"\n" if self.echoes else ANSWER

    def open(self) -> serial.Serial:
        return serial.Serial(self.port.path, 115200, timeout=BOUND_S, exclusive=True)

    def ask(self, line: bytes = b"PING") -> bytes:
        self.host.write(line + b"\n")
        return bytes(self.host.read_until(b"\n"))

    def ask_in_vain(self, line: bytes = b"PING", comes: int = 0) -> bytes:
        """Return the `comes` bytes that are no line, and what else is heard after them."""
        self.host.write(line + b"\n")
        answer = bytes(self.host.read(comes))
        self.host.timeout = QUIET_S
        answer += bytes(self.host.read_until(b"\n"))
        self.host.timeout = BOUND_S
        return answer


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    bench = Bench(tmp_path)
    yield bench
    bench.host.close()
    bench.port.close()


def test_a_host_asks_and_is_answered(bench: Bench) -> None:
    assert bench.ask() == ANSWER
    assert bench.ask() == ANSWER
    assert bench.heard == [b"PING", b"PING"]


def test_every_byte_value_passes_both_ways(tmp_path: Path) -> None:
    everything = bytes(range(256))
    port = PtyPort(lambda data: [Answer(data)], tmp_path / "echo")
    with serial.Serial(port.path, timeout=BOUND_S) as host:
        host.write(everything)
        assert host.read(256) == everything
    port.close()


def test_hosts_may_close_and_open_the_port_at_will(bench: Bench) -> None:
    for _ in range(3):
        bench.host.close()
        bench.host = bench.open()
        assert bench.ask() == ANSWER


def test_a_deaf_device_does_not_act(bench: Bench) -> None:
    bench.faults.set("deaf", times=1)
    assert bench.ask_in_vain() == b""
    assert bench.heard == []
    assert bench.ask() == ANSWER


def test_a_lost_answer_belongs_to_a_command_that_was_obeyed(bench: Bench) -> None:
    bench.faults.set("no-answer", times=1)
    assert bench.ask_in_vain() == b""
    assert bench.heard == [b"PING"]
    assert bench.ask() == ANSWER


def test_half_an_answer_breaks_off_in_the_middle(bench: Bench) -> None:
    bench.faults.set("half-answer", times=1)
    assert bench.ask_in_vain(comes=9) == b"PONG 0123"


def test_garbage_is_no_line_and_no_ascii(bench: Bench) -> None:
    bench.faults.set("garbage", times=1)
    garbage = bench.ask_in_vain(comes=len(ANSWER))
    assert len(garbage) == len(ANSWER)
    assert all(byte >= 0x80 for byte in garbage)


def test_a_late_answer_comes_after_its_time_and_does_not_hold_up_the_next(bench: Bench) -> None:
    bench.echoes = True
    bench.faults.set("late-answer", times=1, delay_s=0.2)
    asked_at = time.monotonic()
    bench.host.write(b"SLOW\nQUICK\n")
    assert [bench.host.read_until(b"\n") for _ in range(2)] == [b"QUICK\n", b"SLOW\n"]
    assert time.monotonic() - asked_at >= 0.2
    assert bench.heard == [b"SLOW", b"QUICK"]


def test_a_duplicate_answer_comes_twice(bench: Bench) -> None:
    bench.faults.set("duplicate-answer", times=1)
    assert bench.ask() + bench.host.read_until(b"\n") == ANSWER * 2


def test_a_wrong_checksum_is_a_digit_in_the_same_place(bench: Bench) -> None:
    bench.faults.set("wrong-checksum", times=1)
    assert bench.ask() == b"PONG 0123456789*A0\n"


def test_a_hang_up_reaches_the_host_and_takes_the_name_away(bench: Bench) -> None:
    bench.faults.set("disconnect", times=1)
    with pytest.raises(serial.SerialException):
        bench.ask()
    bench.port.unplug()
    assert not os.path.lexists(bench.port.path)
    with pytest.raises(serial.SerialException):
        bench.open()


def test_a_device_that_is_plugged_in_again_has_its_name_back(bench: Bench) -> None:
    bench.port.unplug()
    bench.port.unplug()
    bench.host.close()
    bench.port.plug_in()
    bench.port.plug_in()
    bench.host = bench.open()
    assert bench.ask() == ANSWER


def test_a_device_may_be_plugged_in_the_moment_it_hung_up(bench: Bench) -> None:
    for _ in range(30):
        bench.faults.set("disconnect", times=1)
        with pytest.raises(serial.SerialException):
            bench.ask()
        bench.port.plug_in()
        bench.host.close()
        bench.host = bench.open()
        assert bench.ask() == ANSWER


def test_a_counted_fault_strikes_so_many_commands(bench: Bench) -> None:
    bench.faults.set("wrong-checksum", times=3)
    assert [bench.ask() == ANSWER for _ in range(5)] == [False, False, False, True, True]


def test_a_lasting_fault_strikes_until_it_is_cleared(bench: Bench) -> None:
    bench.faults.set("wrong-checksum")
    assert [bench.ask() == ANSWER for _ in range(5)] == [False] * 5
    bench.faults.clear()
    assert bench.ask() == ANSWER


def test_a_fault_of_one_command_leaves_the_others_alone(bench: Bench) -> None:
    bench.faults.set("wrong-checksum", times=1, command="FIRE")
    assert bench.ask(b"ARM 1") == ANSWER
    assert bench.ask(b"now FIRE 1") != ANSWER
    assert bench.ask(b"FIRE 2") == ANSWER


@pytest.mark.parametrize(
    ("act", "named"),
    [
        (lambda faults: faults.set("fire"), "fire"),
        (lambda faults: faults.set("deaf", times=0), "times"),
        (lambda faults: faults.set("deaf", times=True), "times"),
        (lambda faults: faults.set("late-answer", delay_s=-1.0), "delay_s"),
    ],
)
def test_a_fault_that_cannot_be_is_refused(act: Callable[[SerialFaults], None], named: str) -> None:
    with pytest.raises(ValueError, match=named):
        act(SerialFaults())


def test_faults_leave_the_silence_of_a_device_that_never_answers() -> None:
    for kind in set(SerialFault) - {SerialFault.DISCONNECT, SerialFault.WRONG_DEVICE}:
        faults = SerialFaults()
        device = SerialDevice(Lines(b"\n"), lambda line: b"", faults)
        faults.set(kind)
        assert b"".join(answer.data for answer in device.receive(b"PING\n")) == b""


def test_another_device_on_the_port_answers_for_itself_and_nothing_reaches_the_model() -> None:
    faults, reached = SerialFaults(), list[bytes]()

    def answer(line: bytes) -> bytes:
        reached.append(line)
        return ANSWER

    faults.set("wrong-device")
    device = SerialDevice(Lines(b"\n"), answer, faults)
    assert [each.data for each in device.receive(b"PING\n")] == [b"ERROR\r\n"]
    assert reached == []


def test_a_stale_name_of_a_killed_laboratory_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "device").symlink_to("/nowhere")
    bench = Bench(tmp_path)
    assert bench.ask() == ANSWER
    bench.host.close()
    bench.port.close()


def test_a_name_that_another_laboratory_took_over_is_left_to_it(bench: Bench) -> None:
    name = Path(bench.port.path)
    other = PtyPort(lambda data: [], name)
    taken = name.readlink()
    bench.port.close()
    assert name.readlink() == taken
    other.close()
    assert not os.path.lexists(name)


def test_answers_nobody_reads_do_not_stop_the_device(bench: Bench) -> None:
    for _ in range(500):
        bench.host.write(b"PING\n")
    bench.host.reset_input_buffer()
    bench.host.write(b"LAST\n")
    deadline = time.monotonic() + BOUND_S
    while b"LAST" not in bench.heard and time.monotonic() < deadline:
        bench.host.read(64)
    assert bench.heard.count(b"PING") == 500


def test_closing_leaves_no_thread_no_descriptor_and_no_name(tmp_path: Path) -> None:
    threads = threading.active_count()
    descriptors = len(os.listdir("/proc/self/fd"))
    for _ in range(20):
        port = PtyPort(lambda data: [], tmp_path / "device")
        port.close()
        port.close()
    assert threading.active_count() == threads
    assert len(os.listdir("/proc/self/fd")) == descriptors
    assert list(tmp_path.iterdir()) == []


def test_a_device_that_hangs_makes_closing_fail_within_a_bound(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("simulators.wire.pty_port.STOP_WITHIN_S", 0.1)
    inside, release = threading.Event(), threading.Event()

    def hang(_: bytes) -> Sequence[Answer]:
        inside.set()
        release.wait(BOUND_S)
        return []

    port = PtyPort(hang, tmp_path / "device")
    with serial.Serial(port.path) as host:
        host.write(b"x")
        assert inside.wait(BOUND_S)
        with pytest.raises(RuntimeError, match="device"):
            port.close()
        release.set()
        monkeypatch.setattr("simulators.wire.pty_port.STOP_WITHIN_S", BOUND_S)
        port.close()
