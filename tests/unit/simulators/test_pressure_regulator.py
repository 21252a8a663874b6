from __future__ import annotations

import math
from typing import Protocol

import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulators.wire.alicat import PressureRegulator


class Clock(Protocol):
    now: float

    def __call__(self) -> float: ...
    def advance(self, seconds: float) -> None: ...


@pytest.mark.parametrize(
    ("asked", "answered"),
    [
        (["A"], "A +000.00 +000.00\r"),
        (["AS40.00"], "A +000.00 +040.00\r"),
        (["BS7"], "B +000.00 +007.00\r"),
        (["AS40.00", "B"], "B +000.00 +000.00\r"),
        (["AS200.00"], "A +000.00 +200.00\r"),
        (["AS200.01"], "A ?\r"),
        (["AS-1"], "A ?\r"),
        (["AS1e2"], "A ?\r"),
        (["AS"], "A ?\r"),
        (["AV"], "A ?\r"),
        (["C"], ""),
        (["a"], ""),
        ([""], ""),
    ],
)
def test_the_units_answer_as_the_protocol_page_says(
    clock: Clock, asked: list[str], answered: str
) -> None:
    regulator = PressureRegulator(clock)
    assert [regulator.answer(each.encode()) for each in asked][-1] == answered.encode()


def test_a_refused_set_point_changes_nothing(clock: Clock) -> None:
    regulator = PressureRegulator(clock)
    regulator.answer(b"AS40")
    regulator.answer(b"AS900")
    clock.advance(1.0)
    assert regulator.answer(b"A") == b"A +040.00 +040.00\r"


@pytest.mark.parametrize("lags", [0.0, 0.5, 1.0, 3.0])
def test_the_pressure_approaches_the_set_point_with_one_time_constant(
    clock: Clock, lags: float
) -> None:
    regulator = PressureRegulator(clock, lag_s=0.03)
    regulator.answer(b"AS80")
    clock.advance(lags * 0.03)
    assert regulator.pressure_kpa("A", clock.now) == pytest.approx(80 * (1 - math.exp(-lags)))
    assert regulator.pressure_kpa("B", clock.now) == 0.0


def test_a_second_set_point_starts_from_the_pressure_reached(clock: Clock) -> None:
    regulator = PressureRegulator(clock, lag_s=0.03)
    regulator.answer(b"AS80")
    clock.advance(0.03)
    reached = 80 * (1 - math.exp(-1))
    regulator.answer(b"AS20")
    assert regulator.pressure_kpa("A", clock.now) == pytest.approx(reached)
    clock.advance(0.03)
    expected = 20 + (reached - 20) * math.exp(-1)
    assert regulator.pressure_kpa("A", clock.now) == pytest.approx(expected)


def test_a_stuck_regulator_takes_set_points_and_holds_its_pressure(clock: Clock) -> None:
    regulator = PressureRegulator(clock)
    regulator.answer(b"AS40")
    clock.advance(1.0)
    regulator.stick(True)
    regulator.answer(b"AS80")
    clock.advance(10.0)
    assert regulator.answer(b"A") == b"A +040.00 +080.00\r"
    regulator.stick(False)
    clock.advance(1.0)
    assert regulator.answer(b"A") == b"A +080.00 +080.00\r"


@given(line=st.binary(max_size=40))
def test_no_bytes_make_a_unit_raise_or_leave_its_range(line: bytes) -> None:
    regulator = PressureRegulator(lambda: 0.0)
    answer = regulator.answer(line)
    assert answer == b"" or answer.endswith(b"\r")
    assert 0.0 <= regulator.pressure_kpa("A", 1e9) <= 200.0
