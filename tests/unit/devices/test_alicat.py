"""Two regulators on one bus: readings with their age, set points with their echo."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigctl.devices.alicat import AlicatLine, AlicatPair, parse
from rigctl.devices.roles import Reading
from rigctl.devices.serial_port import SerialPort
from rigctl.errors import DeviceAnswerError, DeviceSilentError

MakeDevice = Callable[..., Any]
Build = Callable[[Callable[[bytes], bytes]], AlicatPair]


@pytest.fixture
def build(pty_device: MakeDevice) -> Build:
    def make(answer: Callable[[bytes], bytes]) -> AlicatPair:
        device = pty_device(answer, terminator=b"\r")
        port = SerialPort(
            device.path, part="regulator", baud=19200, answer_timeout_s=0.1, terminator=b"\r"
        )
        return AlicatPair(port, unit_a="A", unit_b="B", clock=iter(range(10, 20)).__next__)

    return make


def test_both_pressures_come_with_unit_and_the_time_they_were_asked_for(build: Build) -> None:
    answers = {b"A\r": b"A +040.00 +041.00\r", b"B\r": b"B -000.12 +000.00\r"}
    pair = build(answers.__getitem__)
    assert pair.pressure() == (Reading(40.0, "kPa", 10), Reading(-0.12, "kPa", 11))
    pair.close()


def test_set_points_are_sent_to_each_unit_with_two_decimals(build: Build) -> None:
    seen: list[bytes] = []

    def answer(message: bytes) -> bytes:
        seen.append(message)
        return message[:1] + b" +000.00 +" + message[2:-1] + b"\r"

    pair = build(answer)
    pair.set_pressure(40.0, 7.128)
    assert seen == [b"AS40.00\r", b"BS7.13\r"]
    pair.close()


def test_a_set_point_that_a_unit_does_not_take_is_an_error_with_both_values(build: Build) -> None:
    pair = build(lambda message: b"A +000.00 +030.00\r")
    with pytest.raises(DeviceAnswerError, match=r"found 30 kPa, allowed 40\.00 kPa"):
        pair.set_pressure(40.0, 0.0)
    pair.close()


def test_venting_sets_both_units_to_zero_even_when_the_first_does_not_take_it(
    build: Build,
) -> None:
    seen: list[bytes] = []

    def answer(message: bytes) -> bytes:
        seen.append(message)
        stays = b"030.00" if message[:1] == b"A" else b"000.00"
        return message[:1] + b" +030.00 +" + stays + b"\r"

    pair = build(answer)
    with pytest.raises(DeviceAnswerError, match="unit A did not take"):
        pair.vent()
    assert sorted(seen) == [b"AS0.00\r", b"BS0.00\r"]
    pair.close()


def test_a_unit_that_does_not_understand_is_named_with_its_answer(build: Build) -> None:
    pair = build(lambda message: b"A ?\r")
    with pytest.raises(DeviceAnswerError, match=r"A \?"):
        pair.check()
    pair.close()


def test_the_other_units_late_line_is_not_taken_for_this_units_pressure(build: Build) -> None:
    pair = build(lambda message: b"B +009.00 +009.00\r" + message[:1] + b" +002.00 +002.00\r")
    first, _ = pair.pressure()
    assert first.value == 2.0
    pair.close()


def test_a_silent_unit_is_named(build: Build) -> None:
    pair = build(lambda message: b"A +002.00 +002.00\r" if message == b"A\r" else b"")
    with pytest.raises(DeviceSilentError, match="no answer to 'B'"):
        pair.pressure()
    pair.close()


@given(st.floats(-999, 999), st.floats(-999, 999), st.sampled_from("AB"))
def test_a_line_comes_back_as_it_was_written(pressure: float, set_point: float, unit: str) -> None:
    line = f"{unit} {pressure:+07.2f} {set_point:+07.2f}"
    found = parse(line, "regulator")
    assert found.unit == unit
    assert abs(found.pressure_kpa - pressure) <= 0.00501
    assert abs(found.set_point_kpa - set_point) <= 0.00501


@given(st.text())
def test_any_other_text_is_an_answer_error_or_a_line_of_finite_numbers(text: str) -> None:
    try:
        found = parse(text, "regulator")
    except DeviceAnswerError:
        return
    assert isinstance(found, AlicatLine)
    assert abs(found.pressure_kpa) < 1e7
