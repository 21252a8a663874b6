from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

import pytest
from hypothesis import given
from hypothesis import strategies as st
from zaber_motion import Library, Units
from zaber_motion.ascii import Axis, Connection
from zaber_motion.exceptions import BadDataException, CommandFailedException

from simulators.wire.faults import SerialDevice, SerialFaults
from simulators.wire.framing import Lines
from simulators.wire.pty_port import PtyPort
from simulators.wire.zaber import ZaberStage


class Clock(Protocol):
    now: float

    def __call__(self) -> float: ...
    def advance(self, seconds: float) -> None: ...


def homed(clock: Clock) -> ZaberStage:
    stage = ZaberStage(clock, speed_mm_per_s=100.0)
    stage.answer(b"/1 1 home")
    clock.advance(1.0)
    return stage


@pytest.mark.parametrize(
    ("asked", "answered"),
    [
        ("/", "@01 0 OK IDLE -- 0"),
        ("/1", "@01 0 OK IDLE -- 0"),
        ("/1 1", "@01 1 OK IDLE -- 0"),
        ("/0 0 00", "@01 0 00 OK IDLE -- 0"),
        ("/1 0 02 get pos:2B", "@01 0 02 OK IDLE -- 0"),
        ("/1 0 02 get pos:2C", None),
        ("/1 1 get limit.max", "@01 1 OK IDLE -- 51200"),
        ("/1 1 move abs 2000\r", "@01 1 OK BUSY -- 0"),
        ("/1 1 move abs 51200", "@01 1 OK BUSY -- 0"),
        ("/1 1 move abs 51201", "@01 1 RJ IDLE -- BADDATA"),
        ("/1 1 move abs -1", "@01 1 RJ IDLE -- BADDATA"),
        ("/1 1 dance", "@01 1 RJ IDLE -- BADCOMMAND"),
        ("/1 2 get pos", "@01 2 RJ IDLE -- BADAXIS"),
        ("/2 1 get pos", None),
        ("get pos", None),
        ("", None),
    ],
)
def test_a_homed_stage_answers_in_the_protocol(
    clock: Clock, asked: str, answered: str | None
) -> None:
    expected = b"" if answered is None else f"{answered}\r\n".encode()
    assert homed(clock).answer(asked.encode()) == expected


def test_a_stage_that_was_switched_on_warns_and_refuses_positions(clock: Clock) -> None:
    stage = ZaberStage(clock)
    assert stage.answer(b"/1 1 warnings") == b"@01 1 OK IDLE WR 01 WR\r\n"
    assert stage.answer(b"/1 1 move abs 100") == b"@01 1 RJ IDLE WR BADCOMMAND\r\n"


def test_a_move_takes_its_way_divided_by_the_speed(clock: Clock) -> None:
    stage = homed(clock)
    stage.answer(b"/1 1 move abs 20158")
    clock.advance(0.05)
    assert stage.position_mm(clock.now) == pytest.approx(5.0)
    assert stage.answer(b"/1 1") == b"@01 1 OK BUSY -- 0\r\n"
    clock.advance(0.0501)
    assert stage.position_mm(clock.now) == pytest.approx(20158 / 2015.75)
    assert stage.answer(b"/1 1") == b"@01 1 OK IDLE -- 0\r\n"


def test_stop_leaves_the_carriage_where_it_is(clock: Clock) -> None:
    stage = homed(clock)
    stage.answer(b"/1 1 move abs 20158")
    clock.advance(0.05)
    assert stage.answer(b"/1 1 stop") == b"@01 1 OK IDLE -- 0\r\n"
    clock.advance(1.0)
    assert stage.position_mm(clock.now) == pytest.approx(5.0)


def test_stopping_a_search_for_home_leaves_the_stage_without_reference(clock: Clock) -> None:
    stage = ZaberStage(clock)
    stage.answer(b"/1 1 home")
    clock.advance(0.001)
    stage.answer(b"/1 1 stop")
    clock.advance(1.0)
    assert b" WR " in stage.answer(b"/1 1")


def test_a_stuck_stage_accepts_moves_and_stays(clock: Clock) -> None:
    stage = homed(clock)
    stage.stick(True)
    assert b" OK " in stage.answer(b"/1 1 move abs 20158")
    clock.advance(1.0)
    assert stage.position_mm(clock.now) == 0.0


@given(
    line=st.binary(max_size=60) | st.from_regex(rb"/1 1( 07)? [a-z. 0-9-]{0,40}", fullmatch=True)
)
def test_no_bytes_make_the_stage_raise(line: bytes) -> None:
    stage = ZaberStage(lambda: 0.0)
    answer = stage.answer(line)
    assert answer == b"" or answer.endswith(b"\r\n")


@pytest.fixture
def stage_and_port(tmp_path: Path) -> Iterator[tuple[ZaberStage, str]]:
    stage = ZaberStage(time.monotonic, speed_mm_per_s=1000.0)
    device = SerialDevice(Lines(b"\n"), stage.answer, SerialFaults())
    port = PtyPort(device.receive, tmp_path / "slide")
    yield stage, port.path
    port.close()


@pytest.fixture
def axis(stage_and_port: tuple[ZaberStage, str]) -> Iterator[Axis]:
    Library.disable_device_db_store()
    with Connection.open_serial_port(stage_and_port[1]) as connection:
        (device,) = connection.detect_devices(identify_devices=False)
        yield device.get_axis(1)


def test_the_vendors_client_homes_and_moves_the_stage(
    stage_and_port: tuple[ZaberStage, str], axis: Axis
) -> None:
    assert not axis.is_homed()
    axis.home()
    assert axis.is_homed()
    axis.move_absolute(20158, Units.NATIVE)
    assert axis.get_position(Units.NATIVE) == 20158
    assert stage_and_port[0].position_mm(time.monotonic()) == pytest.approx(10.0, abs=1e-3)
    assert not axis.is_busy()
    axis.stop()


def test_the_vendors_client_is_told_why_a_move_is_refused(axis: Axis) -> None:
    with pytest.raises(CommandFailedException):
        axis.move_absolute(100, Units.NATIVE)
    axis.home()
    with pytest.raises(BadDataException):
        axis.move_absolute(10**6, Units.NATIVE)
