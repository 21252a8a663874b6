"""Each way a serial line fails has its own error, within its bound, over a real pseudo-terminal."""

from __future__ import annotations

import errno
import logging
import select
import termios
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import serial

from rigctl.devices.serial_port import SerialPort
from rigctl.errors import (
    DeviceAbsentError,
    DeviceAnswerError,
    DeviceBusyError,
    DeviceError,
    DeviceSilentError,
)

BOUND_S = 0.1
MakeDevice = Callable[..., Any]


def opened(path: str, **options: object) -> SerialPort:
    settings = {"part": "thing", "baud": 9600, "answer_timeout_s": BOUND_S} | options
    return SerialPort(path, **settings)  # type: ignore[arg-type]


@pytest.fixture
def elapsed(looks: Any) -> Iterator[None]:
    """The test must end within three times the bound, opening included."""
    yield
    assert looks.now_s < 3 * BOUND_S + 0.2


@pytest.mark.usefixtures("elapsed")
class TestFaults:
    def test_a_silent_device_is_named_with_what_was_asked_and_how_long_was_waited(
        self, pty_device: MakeDevice
    ) -> None:
        port = opened(pty_device().path)
        with pytest.raises(DeviceSilentError) as caught:
            port.ask("HELLO")
        assert "HELLO" in str(caught.value)
        assert "0.1 s" in str(caught.value)
        port.close()

    @pytest.mark.parametrize("answer", [b"", b"HAL", b"\xff\n"])
    def test_where_no_answer_is_due_another_device_may_be_on_the_port(
        self, pty_device: MakeDevice, answer: bytes
    ) -> None:
        path = pty_device(lambda message: answer).path
        port = opened(path)
        with pytest.raises(DeviceError, match=f"another device may be on {path}"):
            port.ask("HELLO")
        port.close()

    def test_half_an_answer_is_shown(self, pty_device: MakeDevice) -> None:
        port = opened(pty_device(lambda message: b"HAL").path)
        with pytest.raises(DeviceAnswerError, match="HAL"):
            port.ask("HELLO")
        port.close()

    def test_bytes_that_are_not_ascii_are_shown(self, pty_device: MakeDevice) -> None:
        port = opened(pty_device(lambda message: b"\xff\x80\n").path)
        with pytest.raises(DeviceAnswerError, match=r"\\xff\\x80"):
            port.ask("HELLO")
        port.close()

    def test_an_endless_line_is_refused_and_not_gathered_for_ever(
        self, pty_device: MakeDevice
    ) -> None:
        port = opened(pty_device(lambda message: b"x" * 3000).path)
        with pytest.raises(DeviceAnswerError):
            port.ask("HELLO")
        port.close()

    def test_a_line_as_long_as_the_port_allows_is_taken_whole(self, pty_device: MakeDevice) -> None:
        port = opened(pty_device(lambda message: b"x" * 3000 + b"\n").path, longest_line=4096)
        assert port.ask("HELLO") == "x" * 3000
        port.close()

    def test_a_hang_up_before_the_question_is_an_absent_device(
        self, pty_device: MakeDevice
    ) -> None:
        device = pty_device()
        port = opened(device.path)
        device.hang_up()
        with pytest.raises(DeviceAbsentError, match="hung up"):
            port.ask("HELLO")
        with pytest.raises(DeviceAbsentError, match="closed since it hung up"):
            port.ask("HELLO")

    @pytest.mark.parametrize("error", [termios.error(5, "I/O error"), OSError(5, "I/O error")])
    def test_a_hang_up_while_the_question_leaves_is_an_absent_device(
        self, pty_device: MakeDevice, monkeypatch: pytest.MonkeyPatch, error: Exception
    ) -> None:
        def fail() -> None:
            raise error

        port = opened(pty_device().path)
        monkeypatch.setattr(port._serial, "flush", fail)
        with pytest.raises(DeviceAbsentError, match="hung up"):
            port.ask("HELLO")
        with pytest.raises(DeviceAbsentError, match="closed since it hung up"):
            port.ask("HELLO")

    def test_a_signal_while_the_question_leaves_is_no_hang_up_and_sends_nothing_twice(
        self, pty_device: MakeDevice, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        heard: list[bytes] = []

        def answer(message: bytes) -> bytes:
            heard.append(message)
            return b"HERE\n"

        port = opened(pty_device(answer).path)
        left = port._serial.flush
        broken_off = [termios.error(errno.EINTR, "Interrupted system call")]

        def drain() -> None:
            if broken_off:
                raise broken_off.pop()
            left()

        monkeypatch.setattr(port._serial, "flush", drain)
        assert port.ask("HELLO") == "HERE"
        assert b"".join(heard) == b"HELLO\n"
        port.close()

    def test_a_port_that_another_program_holds_is_busy(self, pty_device: MakeDevice) -> None:
        device = pty_device()
        other = serial.Serial(device.path, exclusive=True)
        with pytest.raises(DeviceBusyError, match="end the other program"):
            opened(device.path)
        other.close()

    def test_a_port_that_does_not_exist_is_absent(self, tmp_path: Path) -> None:
        with pytest.raises(DeviceAbsentError):
            opened(str(tmp_path / "no-such-port"))

    def test_an_unknown_url_is_a_matter_of_the_configuration(self) -> None:
        with pytest.raises(DeviceAbsentError, match="configuration"):
            opened("nonsense://port")

    def test_a_pseudo_terminal_has_no_rts_line_and_says_so(self, pty_device: MakeDevice) -> None:
        port = opened(pty_device().path)
        with pytest.raises(DeviceError, match="no RTS line"):
            port.set_rts(True)
        port.close()


def test_a_question_is_answered(pty_device: MakeDevice) -> None:
    port = opened(pty_device(lambda message: b"you said " + message).path)
    assert port.ask("HELLO") == "you said HELLO"
    port.close()


def test_what_lay_in_the_input_is_no_answer_and_is_logged(
    pty_device: MakeDevice, caplog: pytest.LogCaptureFixture
) -> None:
    device = pty_device(lambda message: b"fresh\n")
    port = opened(device.path)
    assert port.ask("first") == "fresh"
    device.write(b"stale\n")
    assert select.select([port._serial.fileno()], [], [], 2.0)[0]
    with caplog.at_level(logging.WARNING):
        assert port.ask("second") == "fresh"
    assert "stale" in caplog.text
    port.close()


def test_an_answer_sent_twice_answers_one_question_only(pty_device: MakeDevice) -> None:
    device = pty_device(lambda message: message + message)
    port = opened(device.path)
    assert port.ask("first") == "first"
    assert port.ask("second") == "second"
    port.close()


def test_a_failed_question_tells_of_the_stale_input_before_it(pty_device: MakeDevice) -> None:
    device = pty_device(lambda message: b"old\nolder\n" if message == b"first\n" else b"")
    port = opened(device.path)
    assert port.ask("first") == "old"
    with pytest.raises(DeviceSilentError, match="older"):
        port.ask("second")
    port.close()


def test_late_answers_are_passed_over_for_the_present_one(pty_device: MakeDevice) -> None:
    port = opened(pty_device(lambda message: b"1\n2\n").path)
    assert port.ask("two?", late=lambda line: line == "1") == "2"
    port.close()


def test_only_late_answers_are_silence_and_are_named(pty_device: MakeDevice) -> None:
    port = opened(pty_device(lambda message: b"one\n").path)
    with pytest.raises(DeviceSilentError, match="'one' thrown away"):
        port.ask("two?", late=lambda line: line == "one")
    port.close()


def test_both_modem_lines_are_low_after_opening() -> None:
    port = opened("loop://")
    assert (port._serial.dtr, port._serial.rts) == (False, False)
    port.close()


def test_rts_follows_and_is_seen_on_the_other_side_of_a_loop() -> None:
    port = opened("loop://")
    port.set_rts(True)
    assert port._serial.cts
    port.set_rts(False)
    assert not port._serial.cts
    port.close()


def test_a_lost_port_opens_again_only_when_it_is_told_to(
    pty_device: MakeDevice, tmp_path: Path
) -> None:
    first, second = pty_device(), pty_device(lambda message: b"back\n")
    link = tmp_path / "port"
    link.symlink_to(first.path)
    port = opened(str(link))
    first.hang_up()
    with pytest.raises(DeviceAbsentError):
        port.ask("HELLO")
    link.unlink()
    link.symlink_to(second.path)
    with pytest.raises(DeviceAbsentError):
        port.ask("HELLO")
    assert port.reopen_if_lost() is True
    assert port.reopen_if_lost() is False
    assert port.ask("HELLO") == "back"
    port.close()


def test_a_loss_that_no_question_has_met_is_found_by_looking(
    pty_device: MakeDevice, tmp_path: Path
) -> None:
    first, second = pty_device(), pty_device(lambda message: b"back\n")
    link = tmp_path / "port"
    link.symlink_to(first.path)
    port = opened(str(link))
    first.hang_up()
    link.unlink()
    with pytest.raises(DeviceAbsentError, match="cannot be opened"):
        port.reopen_if_lost()
    link.symlink_to(second.path)
    assert port.reopen_if_lost() is True
    assert port.ask("HELLO") == "back"
    port.close()


def test_closing_twice_does_no_harm_and_a_closed_port_stays_closed(pty_device: MakeDevice) -> None:
    port = opened(pty_device().path)
    port.close()
    port.close()
    port.reopen_if_lost()
    with pytest.raises(DeviceAbsentError, match="closed"):
        port.ask("HELLO")
